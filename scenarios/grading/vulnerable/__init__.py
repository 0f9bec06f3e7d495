"""Grading of vulnerable road users: people and riders of bicycles, matched with tracks by distance."""

"""Tracks of small road users: people and riders of bicycles, as points with a small box."""

"""Scripted traffic: motions written down in the scenario file."""

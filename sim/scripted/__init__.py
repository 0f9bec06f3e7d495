"""Scripted traffic: analytic motions from the scenario file."""

"""Recorded traffic, from tables, SUMO's FCD output and CommonRoad."""

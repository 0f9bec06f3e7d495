"""Recorded traffic in CommonRoad files."""

"""Runs without simulating: recorded scans read back, tracks made by other programs, grading again, and MCAP files."""

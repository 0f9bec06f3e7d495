"""Offline evaluation without simulation: recorded scans, tracks of other programs, regrading, and MCAP export."""

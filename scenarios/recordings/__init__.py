"""Recordings of real sensors: import as recorded scans, tracking, and grading against recorded poses."""

"""Scenario files, run loop, grading, recording and the command line."""

"""Scenario files, run loop, grading, recording and the command line."""

# Unlike in its sister packages, the import as `scenarios` is not refused: pytest does it for tests in scenarios/catalog.

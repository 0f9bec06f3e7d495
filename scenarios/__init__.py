"""Scenario files, run loop, grading, recording and the command line."""

# The import as `scenarios` is not refused as in the sister packages: pytest does it for tests in scenarios/catalog.

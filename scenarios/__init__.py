"""Scenario files, run loop, grading, recording and the command line."""

if not __name__.startswith("luxloop."):
    raise ImportError("scenarios is luxloop.scenarios: change the import to that name", name=__name__)

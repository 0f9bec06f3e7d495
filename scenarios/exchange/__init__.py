"""Tracks and true boxes in files of other programs: readers by format, and their grading without a run."""

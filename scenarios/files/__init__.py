"""Scenario files and their validation, the shipped catalog, and atomic writes."""

"""Candidates for the ego, and new scenario files."""

"""Grading: what the tracker said, held against the truth of the simulation."""

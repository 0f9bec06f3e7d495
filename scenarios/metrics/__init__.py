"""Metrics: one definition each, over the observations of a run."""

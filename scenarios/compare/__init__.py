"""Comparison of two sets of runs: significant changes of metrics, and newly failed expectations."""

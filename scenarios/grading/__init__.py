"""Grading of a run: tracks and detections compared with the simulated ground truth."""

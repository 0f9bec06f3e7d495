"""Data set of a run: scans, labels and ground truth."""

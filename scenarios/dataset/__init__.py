"""Scans and labels of a run as a data set."""

"""Kernels of grading, independent of the tracker's."""

"""Kernels of detection, one file per stage: plain arrays in and out, no config, no random state.

Points are (N, 2) float64 in the ego frame [m]. Group g is rows offset[g] to offset[g + 1].
Sums have a fixed order, so that results do not depend on threads or a BLAS.
"""

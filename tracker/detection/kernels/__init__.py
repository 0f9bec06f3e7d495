"""Hot loops of the fitting half, a file per stage: plain arrays in and out, no config, no random state.

Points are (N, 2) float64 in the ego frame [m]. Ragged groups are rows offset[g] to offset[g + 1].
Sums run over contiguous columns in a fixed order, so that results do not depend on threads or a BLAS.
"""

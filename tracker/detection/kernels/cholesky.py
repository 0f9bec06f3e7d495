"""Kernels of small symmetric systems, in place: a call of LAPACK takes longer than the solution."""

import math

from luxloop.tracker.arrays import Floats
from luxloop.tracker.compiled import kernel


@kernel(error_model="numpy")
def factor(matrix: Floats) -> None:
    """Replace the lower triangle of a symmetric positive definite matrix (n, n) by its Cholesky factor."""
    for i in range(len(matrix)):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = math.sqrt(rest) if i == j else rest / matrix[j, j]


@kernel(error_model="numpy")
def solve(triangle: Floats, vector: Floats) -> None:
    """Replace a vector (n,) by the solution x of L L^T x = vector, with the Cholesky factor L in `triangle`."""
    for i in range(len(vector)):
        rest = vector[i]
        for k in range(i):
            rest -= triangle[i, k] * vector[k]
        vector[i] = rest / triangle[i, i]
    for i in range(len(vector) - 1, -1, -1):
        rest = vector[i]
        for k in range(i + 1, len(vector)):
            rest -= triangle[k, i] * vector[k]
        vector[i] = rest / triangle[i, i]

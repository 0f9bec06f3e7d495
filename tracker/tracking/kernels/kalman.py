"""Prediction and correction of a batch of Kalman filters."""

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.compiled import kernel


@kernel()
def predict(mean: Floats, covariance: Floats, transition: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Return the means (K, n) and covariances (K, n, n) after one time step.

    Transitions and process noise (S, n, n) repeat after S filters.
    """
    count, n = mean.shape
    moved, spread = np.zeros((count, n)), np.empty((count, n, n))
    half = np.empty((n, n))
    for k in range(count):
        f, q = transition[k % len(transition)], noise[k % len(noise)]
        for i in range(n):
            for j in range(n):
                half[i, j] = 0.0
            for j in range(n):
                if f[i, j] != 0.0:  # transitions are sparse
                    moved[k, i] += f[i, j] * mean[k, j]
                    for m in range(n):
                        half[i, m] += f[i, j] * covariance[k, j, m]
        for i in range(n):
            for j in range(n):
                spread[k, i, j] = q[i, j]
        for j in range(n):
            for m in range(n):
                if f[j, m] != 0.0:
                    for i in range(n):
                        spread[k, i, j] += half[i, m] * f[j, m]
    return moved, spread


@kernel()
def correct(mean: Floats, covariance: Floats, residual: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Return the means (K, n) and covariances (K, n, n) after a measurement of the first one or two states.

    Innovations are (K, m), and the measurement noise (S, m, m) is that of K / S successive filters each.
    """
    count, n = mean.shape
    corrected, spread = np.empty((count, n)), np.empty((count, n, n))
    for k in range(count):
        r = noise[k * len(noise) // count]
        gain = gains(covariance[k], r)
        for i in range(n):
            corrected[k, i] = mean[k, i]
            for m in range(len(r)):
                corrected[k, i] += gain[i, m] * residual[k, m]
            for j in range(i + 1):
                low, high = covariance[k, i, j], covariance[k, j, i]
                for m in range(len(r)):
                    low -= gain[i, m] * covariance[k, m, j]
                    high -= gain[j, m] * covariance[k, m, i]
                spread[k, i, j] = spread[k, j, i] = 0.5 * (low + high)
    return corrected, spread


@kernel()
def gains(covariance: Floats, noise: Floats) -> Floats:
    """(n, m) Kalman gain of a measurement of the first one or two states, with noise (m, m)."""
    n, m = len(covariance), len(noise)
    gain = np.empty((n, m))
    xx = covariance[0, 0] + noise[0, 0]
    if m == 1:
        for i in range(n):
            gain[i, 0] = covariance[i, 0] / xx
        return gain
    xy, yy = covariance[0, 1] + noise[0, 1], covariance[1, 1] + noise[1, 1]
    determinant = xx * yy - xy * xy
    for i in range(n):
        gain[i, 0] = (covariance[i, 0] * yy - covariance[i, 1] * xy) / determinant
        gain[i, 1] = (covariance[i, 1] * xx - covariance[i, 0] * xy) / determinant
    return gain

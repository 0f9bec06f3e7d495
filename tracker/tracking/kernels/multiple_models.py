"""Transitions, mixing and scores of the M models of T filter banks, see `luxloop.tracker.tracking.mma`."""

import math
from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.compiled import kernel

NO_SPEED_MPS = 1e-9
"""Speed below which a filter has no direction [m/s]; the speed of a stationary vehicle tends to 0 and underflows."""


class Changes(NamedTuple):
    """Changes of the mode of a vehicle in one time step."""

    leaves: float
    """Probability of the change to any one other mode."""
    stops: float
    """Probability that a slow vehicle changes to the stationary model."""
    stationary: int
    """Index of that model, -1 for none."""
    standing_mps: float
    """A slower vehicle is slow [m/s]."""
    least: float
    """Probability of the change to that model, at least."""


@kernel()
def transitions(mean: Floats, covariance: Floats, changes: Changes) -> Floats:
    """(T, M, M) probability of the change from one mode (row) to another (column) in one time step."""
    count, models = mean.shape[:2]
    chain = np.empty((count, models, models))
    for t in range(count):
        for i in range(models):
            total = 0.0
            for j in range(models):
                chain[t, i, j] = 0.0 if i == j else changes.leaves
                if i != j and j == changes.stationary:
                    stops = changes.stops * slow(mean[t, i], covariance[t, i], changes.standing_mps)
                    chain[t, i, j] = max(stops, changes.least)
                total += chain[t, i, j]
            kept = 1.0
            for j in range(models):
                chain[t, i, j] /= max(total, 1.0)  # after a long gap every mode has been left
                kept -= chain[t, i, j]
            chain[t, i, i] = kept
    return chain


@kernel()
def slow(mean: Floats, covariance: Floats, limit_mps: float) -> float:
    """Probability by a filter that the speed along its direction of motion is below the limit."""
    speed = math.hypot(mean[2], mean[3])
    x, y = 1.0, 0.0
    if speed > NO_SPEED_MPS:
        x, y = mean[2] / speed, mean[3] / speed
    variance = x * x * covariance[2, 2] + 2.0 * x * y * covariance[2, 3] + y * y * covariance[3, 3]
    scale = 1.0 / math.sqrt(2.0 * variance)
    return 0.5 * (math.erfc((speed - limit_mps) * scale) - math.erfc((speed + limit_mps) * scale))


@kernel()
def mix(mean: Floats, covariance: Floats, probability: Floats, chain: Floats) -> tuple[Floats, Floats, Floats]:
    """Return mixed means (T, J, n) and covariances (T, J, n, n), and the probabilities (T, J) before an observation.

    The probabilities of the M models are (T, M), and those of a change to each of J modes (T, M, J).
    """
    count, models, n = mean.shape
    modes = chain.shape[2]
    mixed, spread, prior = np.zeros((count, modes, n)), np.zeros((count, modes, n, n)), np.zeros((count, modes))
    share, off = np.empty(models), np.empty(n)
    for t in range(count):
        for j in range(modes):
            for i in range(models):
                prior[t, j] += probability[t, i] * chain[t, i, j]
            for i in range(models):
                share[i] = probability[t, i] * chain[t, i, j] / prior[t, j]
                for a in range(n):
                    mixed[t, j, a] += share[i] * mean[t, i, a]
            for i in range(models):
                for a in range(n):
                    off[a] = mean[t, i, a] - mixed[t, j, a]
                for a in range(n):
                    for b in range(n):
                        spread[t, j, a, b] += share[i] * (covariance[t, i, a, b] + off[a] * off[b])
    return mixed, spread, prior


@kernel()
def mahalanobis(residual: Floats, covariance: Floats, noise: Floats) -> tuple[float, float]:
    """Squared Mahalanobis distance of an innovation (2,), and determinant of its covariance.

    That is the sum of the covariance of a filter (n, n), of its first two states, and of the noise (2, 2).
    """
    xx, yy = covariance[0, 0] + noise[0, 0], covariance[1, 1] + noise[1, 1]
    xy = covariance[0, 1] + noise[0, 1]
    (x, y), determinant = residual, xx * yy - xy * xy
    return (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant, determinant


@kernel()
def update(probability: Floats, evidence: Floats, floor: float) -> Floats:
    """Return the model probabilities (T, M) after evidence (T, M), not below the floor; see `tracker.tracking.mma`."""
    count, models = probability.shape
    posterior = np.empty((count, models))
    for t in range(count):
        highest = -np.inf
        for m in range(models):
            posterior[t, m] = math.log(probability[t, m]) + evidence[t, m]
            highest = max(highest, posterior[t, m])
        total = 0.0
        for m in range(models):
            posterior[t, m] = math.exp(posterior[t, m] - highest)
            total += posterior[t, m]
        total_above = 0.0
        for m in range(models):
            posterior[t, m] = max(posterior[t, m] / total, floor)
            total_above += posterior[t, m]
        for m in range(models):
            posterior[t, m] /= total_above
    return posterior


@kernel()
def score(covariance: Floats, residual: Floats, noise: Floats, tail_dof: float) -> tuple[Floats, Floats]:
    """Return the log-likelihoods (T, M) of a t-distribution, and the factors (T,) on the measurement noise.

    Filters have covariances (T, M, n, n), innovations (T, M, 2), and the noise (T, 2, 2) of their measurements.
    """
    count, models = residual.shape[:2]
    evidence, scale = np.empty((count, models)), np.empty(count)
    for t in range(count):
        nearest = np.inf
        for m in range(models):
            squared, determinant = mahalanobis(residual[t, m], covariance[t, m], noise[t])
            nearest = min(nearest, squared)
            tail = -0.5 * (tail_dof + 2.0) * math.log1p(squared / tail_dof)
            evidence[t, m] = tail - 0.5 * math.log((2.0 * math.pi) ** 2 * determinant)
        scale[t] = max(1.0, (tail_dof + nearest) / (tail_dof + 2.0))
    return evidence, scale

"""Prediction and correction of T filter banks, and of T sets of independent filters, of M models of n states each."""

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.compiled import kernel
from luxloop.tracker.tracking import filters
from luxloop.tracker.tracking.kernels import multiple_models

Banks = tuple[Floats, Floats, Floats]
"""Means (T, M, n), covariances (T, M, n, n), and model probabilities (T, M)."""


@kernel()
def predict(
    mean: Floats,
    covariance: Floats,
    probability: Floats,
    transition: Floats,
    noise: Floats,
    changes: multiple_models.Changes,
) -> Banks:
    """Mix the filters of each bank and move them on by one time step.

    Transitions and process noise are (M, n, n), or (T * M, n, n) for motions that differ.
    """
    chain = multiple_models.transitions(mean, covariance, changes)
    mean, covariance, probability = multiple_models.mix(mean, covariance, probability, chain)
    mean, covariance = move(mean, covariance, transition, noise)
    return mean, covariance, probability


@kernel()
def move(mean: Floats, covariance: Floats, transition: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Return the means (T, M, n) and covariances (T, M, n, n) of filters after one time step."""
    rows, n = mean.shape[0] * mean.shape[1], mean.shape[2]
    moved, spread = filters.predict_rows(mean.reshape(rows, n), covariance.reshape(rows, n, n), transition, noise)
    return moved.reshape(mean.shape), spread.reshape(covariance.shape)


@kernel()
def inflated(covariance: Floats, added: Floats) -> Floats:
    """Return covariances (T, M, n, n) with (T, 2, 2) added to those of the first two states."""
    result = covariance.copy()
    for t in range(len(added)):
        for m in range(covariance.shape[1]):
            for a in range(2):
                for b in range(2):
                    result[t, m, a, b] += added[t, a, b]
    return result


@kernel()
def observe(
    mean: Floats,
    covariance: Floats,
    probability: Floats,
    residual: Floats,
    noise: Floats,
    released: Floats,
    tail_dof: float,
    floor: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Score and correct banks by residuals (T, M, 2) [m]; return them, and the covariance (T, 2, 2) of the updates.

    `noise` (T, 2, 2) is that of the measurements, and `released` (T, 2, 2) is added to the positions before [m^2].
    """
    covariance = inflated(covariance, released)
    evidence, scale = multiple_models.score(covariance, residual, noise, tail_dof)
    probability = multiple_models.update(probability, evidence, floor)
    used = np.empty_like(noise)
    for t in range(len(noise)):
        for a in range(2):
            for b in range(2):
                used[t, a, b] = scale[t] * noise[t, a, b]
    mean, covariance = corrected(mean, covariance, residual, used)
    return mean, covariance, probability, used


@kernel()
def corrected(mean: Floats, covariance: Floats, residual: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Return the means (T, M, n) and covariances (T, M, n, n) of filters after innovations (T, M, 2)."""
    rows, n = mean.shape[0] * mean.shape[1], mean.shape[2]
    states = mean.reshape(rows, n), covariance.reshape(rows, n, n)
    moved, spread = filters.correct_rows(states[0], states[1], residual.reshape(rows, 2), noise)
    return moved.reshape(mean.shape), spread.reshape(covariance.shape)


@kernel()
def observe_independent(
    mean: Floats, covariance: Floats, measured: Floats, noise: Floats, released: Floats
) -> tuple[Floats, Floats, Floats]:
    """Correct independent filters by corners (T, 2) [m]; return them and their squared innovations (T, M), normalised.

    `noise` (T, 2, 2) is that of the measurements, and `released` (T, 2, 2) is added to the positions before [m^2].
    """
    covariance, residual = inflated(covariance, released), np.empty((*mean.shape[:2], 2))
    squared = np.empty(mean.shape[:2])
    for t in range(mean.shape[0]):
        for m in range(mean.shape[1]):
            residual[t, m, 0], residual[t, m, 1] = measured[t, 0] - mean[t, m, 0], measured[t, 1] - mean[t, m, 1]
            squared[t, m], _ = multiple_models.mahalanobis(residual[t, m], covariance[t, m], noise[t])
    mean, covariance = corrected(mean, covariance, residual, noise)
    return mean, covariance, squared

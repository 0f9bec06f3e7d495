"""Multiple-model association: score the filters of a bank, equations (10) to (12).

The paper runs the filters independently, without mixing. After a manoeuvre its constant velocity filter is wrong for
seconds, and of no use when the vehicle returns to that mode. Here a vehicle may change its mode between two scans (a
Markov chain before (12)), and each filter starts a scan from the mixture of the filters that may have led to its mode
(Blom and Bar-Shalom 1988). The reported estimate is that of the paper: the filter of the highest score.
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking.filters import correct_rows, predict_rows

LEAST_PROBABILITY = 1e-9
"""Lower limit of a model probability, which keeps its logarithm finite."""

STATIONARY, CV, CA = (MODELS.index(model) for model in ("stationary", "cv", "ca"))
"""Their indices in the standard set."""

STANDING_MPS = 0.28
"""A slower vehicle is stationary [m/s]: 1 km/h, far below the creep of an idling automatic car. A corner with an error
of 5 cm, observed for a second at 12.5 Hz, gives the speed to 5 cm/s, a fifth of this."""

PROBABILITY_FLOOR = 0.02
"""Lower limit of every probability of independent filters, so that a model can recover at a change of mode."""

STOPPING_TIME_S = 0.2
"""Time constant of the change from a moving model below that speed to the stationary one [s]."""


@dataclass(frozen=True, slots=True)
class MmaConfig:
    """Multiple-model association."""

    method: Literal["mma", "imm", "average", "paper"] = "mma"
    """`mma`: mixing, and selection of the filter of the highest score. `imm`: filterpy's interacting multiple model,
    which reports the mean of all models, weighted by their probabilities. `average`: independent filters, and that mean
    (Magill 1965). `paper`: filterpy's independent filters, and selection of the highest score. Change it to compare
    selections."""
    mode_time_s: float = 3.0
    """Mean time in a mode [s]: the time between two actions in urban traffic. Increase it for motorways."""
    tail_dof: float = 4.0
    """Degrees of freedom of the t-distribution of corner noise: few mean heavy tails. Set 1e6, nearly normal, to
    compare with the paper."""

    def __post_init__(self) -> None:
        if self.mode_time_s < STOPPING_TIME_S:
            raise ValueError(f"mode_time_s is {self.mode_time_s}; give {STOPPING_TIME_S} or more")
        if self.tail_dof <= 0:
            raise ValueError(f"tail_dof is {self.tail_dof}; give a number above 0, as 1e6 for normal tails")


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
    least: float
    """Probability of the change to that model, at least."""


@kernel()
def transitions(mean: Floats, covariance: Floats, changes: Changes) -> Floats:
    """(T, M, M) probability of the change from one mode (row) to another (column) in one time step.

    A vehicle leaves its mode for any other one after `mode_time_s` on average. The change to stationary depends on
    the state, as in Seah and Hwang (2009): a moving model with a low speed describes a stationary vehicle. The
    likelihood cannot separate the two, because at speed 0 both filters predict the same position.
    """
    count, models = mean.shape[:2]
    chain = np.empty((count, models, models))
    for t in range(count):
        for i in range(models):
            total = 0.0
            for j in range(models):
                chain[t, i, j] = 0.0 if i == j else changes.leaves
                if i != j and j == changes.stationary:
                    stops = changes.stops * slow(mean[t, i], covariance[t, i], STANDING_MPS)
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
    speed = elementary.hypot(mean[2], mean[3])
    x, y = 1.0, 0.0
    if speed > NO_SPEED_MPS:
        x, y = mean[2] / speed, mean[3] / speed
    variance = x * x * covariance[2, 2] + 2.0 * x * y * covariance[2, 3] + y * y * covariance[3, 3]
    scale = 1.0 / math.sqrt(2.0 * variance)
    return 0.5 * (elementary.erfc((speed - limit_mps) * scale) - elementary.erfc((speed + limit_mps) * scale))


@kernel()
def mix(mean: Floats, covariance: Floats, probability: Floats, chain: Floats) -> tuple[Floats, Floats, Floats]:
    """Return mixed means (T, J, n) and covariances (T, J, n, n), and the probabilities (T, J) before an observation.

    The probabilities of the M models are (T, M), and those of a change to each of J modes (T, M, J).
    Filter j starts from the mean and covariance of the mixture of all filters i, weighted by the probability that the
    vehicle was in mode i if it is in mode j now (Bar-Shalom, Li, Kirubarajan 2001, 11.6.6).
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
    """Return the model probabilities (T, M) after one observation, equation (12) in logarithms, not below the floor.

    The evidence (T, M) is the logarithm of (11) under each model. A common offset cancels, so that outliers do not
    underflow.
    """
    count, models = probability.shape
    posterior = np.empty((count, models))
    for t in range(count):
        highest = -np.inf
        for m in range(models):
            posterior[t, m] = elementary.log(probability[t, m]) + evidence[t, m]
            highest = max(highest, posterior[t, m])
        total = 0.0
        for m in range(models):
            posterior[t, m] = elementary.exp(posterior[t, m] - highest)
            total += posterior[t, m]
        total_above = 0.0
        for m in range(models):
            posterior[t, m] = max(posterior[t, m] / total, floor)
            total_above += posterior[t, m]
        for m in range(models):
            posterior[t, m] /= total_above
    return posterior


@kernel()
def score(covariance: Floats, innovation: Floats, noise: Floats, tail_dof: float) -> tuple[Floats, Floats]:
    """Return the log-likelihoods (T, M) of a t-distribution, and the factors (T,) on the measurement noise.

    Filters have covariances (T, M, n, n), innovations (T, M, 2), and the noise (T, 2, 2) of their measurements.

    The paper prints S = H P H' in (10), without the measurement noise; here S = H P H' + R. In place of the normal
    density (11), the likelihood is Student's t-distribution with `tail_dof` degrees of freedom, whose limit is the
    normal distribution: a corner sometimes jumps, from a bumper to a hood or at an occlusion boundary, and a single
    jump must not decide for a model. The factor is the mean scale of the covariance under that distribution, by the
    innovation of the nearest model (Roth, Ozkan, Gustafsson 2013).
    """
    count, models = innovation.shape[:2]
    evidence, scale = np.empty((count, models)), np.empty(count)
    for t in range(count):
        nearest = np.inf
        for m in range(models):
            squared, determinant = mahalanobis(innovation[t, m], covariance[t, m], noise[t])
            nearest = min(nearest, squared)
            tail = -0.5 * (tail_dof + 2.0) * elementary.log1p(squared / tail_dof)
            evidence[t, m] = tail - 0.5 * elementary.log((2.0 * math.pi) ** 2 * determinant)
        scale[t] = max(1.0, (tail_dof + nearest) / (tail_dof + 2.0))
    return evidence, scale


def changes(dt: float, config: MmaConfig, models: tuple[str, ...]) -> Changes:
    """Return the changes of the mode within `dt` [s]."""
    leaves = -elementary.expm1(-dt / config.mode_time_s) / max(len(models) - 1, 1)
    stops = -elementary.expm1(-dt / STOPPING_TIME_S)
    stationary = models.index("stationary") if "stationary" in models else -1
    return Changes(leaves, stops, stationary, LEAST_PROBABILITY)


Banks = tuple[Floats, Floats, Floats]
"""Means (T, M, n), covariances (T, M, n, n), and model probabilities (T, M)."""


@kernel()
def predict_banks(
    mean: Floats,
    covariance: Floats,
    probability: Floats,
    transition: Floats,
    noise: Floats,
    changes: Changes,
) -> Banks:
    """Mix the filters of each bank and move them on by one time step.

    Transitions and process noise are (M, n, n), or (T * M, n, n) for motions that differ.
    """
    chain = transitions(mean, covariance, changes)
    mean, covariance, probability = mix(mean, covariance, probability, chain)
    mean, covariance = move(mean, covariance, transition, noise)
    return mean, covariance, probability


@kernel()
def move(mean: Floats, covariance: Floats, transition: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Return the means (T, M, n) and covariances (T, M, n, n) of filters after one time step."""
    rows, n = mean.shape[0] * mean.shape[1], mean.shape[2]
    moved, spread = predict_rows(mean.reshape(rows, n), covariance.reshape(rows, n, n), transition, noise)
    return moved.reshape(mean.shape), spread.reshape(covariance.shape)


@kernel()
def correct_banks(
    mean: Floats,
    covariance: Floats,
    probability: Floats,
    innovation: Floats,
    noise: Floats,
    tail_dof: float,
    floor: float,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Score and correct banks by innovations (T, M, 2) [m]; return them, and the covariance (T, 2, 2) of the updates.

    `noise` (T, 2, 2) is that of the measurements [m^2].
    """
    evidence, scale = score(covariance, innovation, noise, tail_dof)
    probability = update(probability, evidence, floor)
    used = np.empty_like(noise)
    for t in range(len(noise)):
        for a in range(2):
            for b in range(2):
                used[t, a, b] = scale[t] * noise[t, a, b]
    mean, covariance = corrected(mean, covariance, innovation, used)
    return mean, covariance, probability, used


@kernel()
def corrected(mean: Floats, covariance: Floats, innovation: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Return the means (T, M, n) and covariances (T, M, n, n) of filters after innovations (T, M, 2)."""
    rows, n = mean.shape[0] * mean.shape[1], mean.shape[2]
    states = mean.reshape(rows, n), covariance.reshape(rows, n, n)
    moved, spread = correct_rows(states[0], states[1], innovation.reshape(rows, 2), noise)
    return moved.reshape(mean.shape), spread.reshape(covariance.shape)


@kernel()
def correct_independent(
    mean: Floats, covariance: Floats, measured: Floats, noise: Floats
) -> tuple[Floats, Floats, Floats]:
    """Correct independent filters by corners (T, 2) [m]; return them and their squared innovations (T, M), normalised.

    `noise` (T, 2, 2) is that of the measurements [m^2].
    """
    innovation, squared = np.empty((*mean.shape[:2], 2)), np.empty(mean.shape[:2])
    for t in range(mean.shape[0]):
        for m in range(mean.shape[1]):
            innovation[t, m, 0], innovation[t, m, 1] = measured[t, 0] - mean[t, m, 0], measured[t, 1] - mean[t, m, 1]
            squared[t, m], _ = mahalanobis(innovation[t, m], covariance[t, m], noise[t])
    mean, covariance = corrected(mean, covariance, innovation, noise)
    return mean, covariance, squared

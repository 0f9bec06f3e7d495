"""Multiple-model association: score the filters of a bank, equations (10) to (12).

The paper runs the filters independently, without mixing. After a manoeuvre its constant velocity filter is wrong for
seconds, and of no use when the vehicle returns to that mode. Here a vehicle may change its mode between two scans (a
Markov chain before (12)), and each filter starts a scan from the mixture of the filters that may have led to its mode
(Blom and Bar-Shalom 1988). The reported estimate is that of the paper: the filter of the highest score.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from tracker.arrays import Floats
from tracker.geometry import mahalanobis
from tracker.records import MODEL_NAMES, MODELS
from tracker.tracking.filters import Filters

LEAST_PROBABILITY = 1e-9
"""Lower limit of a model probability, which keeps its logarithm finite."""

NO_SPEED_MPS = 1e-9
"""Speed below which a filter has no direction [m/s]; the speed of a stationary vehicle tends to 0 and underflows."""

STATIONARY, CV, CA = (MODELS.index(model) for model in ("stationary", "cv", "ca"))
"""Their indices in the standard set."""


@dataclass(frozen=True, slots=True)
class MmaConfig:
    """Multiple-model association."""

    method: Literal["mma", "imm", "average", "paper"] = "mma"
    """`mma`: mixing, and selection of the filter of the highest score. `imm`: filterpy's interacting multiple model,
    which reports the mean of all models, weighted by their probabilities. `average`: independent filters, and that mean
    (Magill 1965). `paper`: filterpy's independent filters, and selection of the highest score; both with
    `probability_floor`."""
    mode_time_s: float = 3.0
    """Mean time in a mode [s]: the time between two actions in urban traffic."""
    standing_mps: float = 0.28
    """A slower vehicle is stationary [m/s]: 1 km/h, far below the creep of an idling automatic car. A corner with an
    error of 5 cm, observed for a second at 12.5 Hz, gives the speed to 5 cm/s, a fifth of this."""
    stopping_time_s: float = 0.2
    """Time constant of the change from a moving model below that speed to the stationary one [s]."""
    tail_dof: float = 4.0
    """Degrees of freedom of the t-distribution of corner noise: few mean heavy tails, 1e6 is nearly normal."""
    probability_floor: float = 0.02
    """`paper` and `average`: lower limit of every probability, so that a model can recover at a change of mode."""

    def __post_init__(self) -> None:
        if not 0 < self.probability_floor < 1 / len(MODEL_NAMES):
            raise ValueError(f"probability_floor must lie between 0 and 1/{len(MODEL_NAMES)}")
        if not 0 < self.stopping_time_s <= self.mode_time_s:
            raise ValueError("stopping_time_s must be above 0 and no longer than mode_time_s")
        if self.tail_dof <= 0:
            raise ValueError(f"tail_dof is {self.tail_dof}; give a number above 0, as 1e6 for normal tails")


def initial_probability(count: int = len(MODELS)) -> Floats:
    """(M,) equal probabilities of `count` models."""
    return np.full(count, 1 / count)


def transitions(filters: Filters, dt: float, config: MmaConfig, models: tuple[str, ...] = MODELS) -> Floats:
    """(..., M, M) probability of the change from one mode (row) to another (column) within `dt` [s].

    A vehicle leaves its mode for any other one after `mode_time_s` on average. The change to stationary depends on
    the state, as in Seah and Hwang (2009): a moving model with a low speed describes a stationary vehicle. The
    likelihood cannot separate the two, because at speed 0 both filters predict the same position.
    """
    leaves = -np.expm1(-dt / config.mode_time_s) / max(len(models) - 1, 1)
    chain = np.full((*filters.mean.shape[:-1], len(models)), leaves)
    if "stationary" in models:
        stops = -np.expm1(-dt / config.stopping_time_s) * slow(filters, config.standing_mps)
        chain[..., models.index("stationary")] = np.maximum(stops, LEAST_PROBABILITY)
    same = np.arange(len(models))
    chain[..., same, same] = 0.0
    chain /= np.maximum(chain.sum(axis=-1, keepdims=True), 1.0)  # after a long gap every mode has been left
    chain[..., same, same] = 1.0 - chain.sum(axis=-1)
    return chain


def slow(filters: Filters, limit_mps: float) -> Floats:
    """(..., M) probability by each filter that the speed along its direction of motion is below the limit."""
    velocity, covariance = filters.mean[..., 2:4], filters.covariance[..., 2:4, 2:4]
    speed = np.hypot(velocity[..., 0], velocity[..., 1])
    moves = speed[..., None] > NO_SPEED_MPS
    direction = np.where(moves, velocity / np.maximum(speed, NO_SPEED_MPS)[..., None], (1.0, 0.0))
    std = np.sqrt(np.einsum("...i,...ij,...j->...", direction, covariance, direction))
    return np.asarray(scipy.special.ndtr((limit_mps - speed) / std) - scipy.special.ndtr((-limit_mps - speed) / std))


def mix(filters: Filters, probability: Floats, chain: Floats) -> tuple[Filters, Floats]:
    """Return the mixed filters, and the model probabilities (..., M) before (12).

    Bar-Shalom, Li, Kirubarajan (2001), 11.6.6: filter j starts from the mean and covariance of the mixture of all
    filters i, weighted by the probability that the vehicle was in mode i if it is in mode j now.
    """
    flow = probability[..., None] * chain
    prior = flow.sum(axis=-2)
    share = flow / prior[..., None, :]
    mean = share.swapaxes(-1, -2) @ filters.mean
    difference = filters.mean[..., :, None, :] - mean[..., None, :, :]
    second_moment = filters.covariance[..., :, None, :, :] + difference[..., :, None] * difference[..., None, :]
    return Filters(mean, np.einsum("...ij,...ijkl->...jkl", share, second_moment)), prior


def score(filters: Filters, residual: Floats, noise: Floats, tail_dof: float) -> tuple[Floats, Floats]:
    """Log-likelihood (11) of each model, and a scale for the measurement noise.

    The paper prints S = H P H' in (10), without the measurement noise; here S = H P H' + R. In place of the normal
    density (11), the likelihood is Student's t-distribution with `tail_dof` degrees of freedom, whose limit is the
    normal distribution: a corner sometimes jumps, from a bumper to a hood or at an occlusion boundary, and a single
    jump must not decide for a model.

    Parameters
    ----------
    residual
        (..., M, 2) innovations [m].
    noise
        (..., 2, 2) covariance of the measurement [m^2].

    Returns
    -------
    Floats
        (..., M) log-likelihoods.
    Floats
        (...) factor on the measurement noise of this update, by the innovation of the nearest model: the mean scale
        of the covariance under the t-distribution (Roth, Ozkan, Gustafsson 2013).
    """
    squared, determinant = mahalanobis(residual, filters.covariance[..., :2, :2] + noise[..., None, :, :])
    density = -0.5 * (tail_dof + 2) * np.log1p(squared / tail_dof) - 0.5 * np.log((2 * np.pi) ** 2 * determinant)
    return density, np.maximum(1.0, (tail_dof + squared.min(axis=-1)) / (tail_dof + 2))


def update(probability: Floats, evidence: Floats, floor: float = LEAST_PROBABILITY) -> Floats:
    """Return the model probabilities (..., M) after one observation, equation (12) in logarithms.

    Parameters
    ----------
    probability
        (..., M) before the observation, all above 0.
    evidence
        (..., M) logarithm of (11) under each model. A common offset cancels, so that outliers do not underflow.
    floor
        Lower limit of a probability.
    """
    score = np.log(probability) + evidence
    posterior = np.exp(score - score.max(axis=-1, keepdims=True))
    posterior = np.maximum(posterior / posterior.sum(axis=-1, keepdims=True), floor)
    return np.asarray(posterior / posterior.sum(axis=-1, keepdims=True))

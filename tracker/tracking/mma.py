"""Multiple-model association: which filter of the bank explains the vehicle best, equations (10) to (12).

The paper's filters never talk. After a manoeuvre the one of constant velocity is off for seconds, and when it is wanted
again it is of no use. Here a vehicle may change its mode between two scans (a Markov chain before (12)), and a filter
starts each scan from what those believed that the vehicle may have followed until then: the mixing of Blom and
Bar-Shalom (1988). What is reported stays the paper's: the filter of the highest score.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import ndtr

from tracker.arrays import Floats
from tracker.geometry import mahalanobis
from tracker.records import MODELS
from tracker.tracking.filters import Filters

LEAST_PROBABILITY = 1e-9
"""Of any model: nothing is impossible, and its logarithm is finite."""

NO_SPEED_MPS = 1e-9
"""Slower filters have no direction [m/s]; those of a vehicle that has stood for long tend to 0 and underflow."""

STATIONARY, CV, CA = (MODELS.index(model) for model in ("stationary", "cv", "ca"))


@dataclass(frozen=True, slots=True)
class MmaConfig:
    """Multiple-model association."""

    method: Literal["mma", "imm", "paper"] = "mma"
    """`mma`: as said above. `imm`: filterpy's interacting multiple model, whose estimate is the mean of all models by
    their probabilities. `paper`: filters that never talk, and the floor."""
    mode_time_s: float = 3.0
    """A vehicle keeps to its mode for about this long [s]: the time between two actions in urban traffic."""
    standing_mps: float = 0.4
    """What is slower stands [m/s]: between the limits at which a vehicle begins and ceases to move ..."""
    stopping_time_s: float = 0.2
    """... and a moving model that is so slow hands over within this time [s]."""
    tail_dof: float = 4.0
    """Degrees of freedom of the corner noise's distribution: few mean heavy tails, 1e6 is as good as normal."""
    probability_floor: float = 0.02
    """`paper`: no model's probability falls below this, so that it can come back when the vehicle changes its mind."""

    def __post_init__(self) -> None:
        if not 0 < self.probability_floor < 1 / len(MODELS):
            raise ValueError(f"probability_floor must lie between 0 and 1/{len(MODELS)}")
        if not 0 < self.stopping_time_s <= self.mode_time_s:
            raise ValueError("stopping_time_s must be above 0 and no longer than mode_time_s")
        if self.tail_dof <= 0:
            raise ValueError(f"tail_dof is {self.tail_dof}; give a number above 0, as 1e6 for normal tails")


def initial_probability() -> Floats:
    """(M,) all models alike."""
    return np.full(len(MODELS), 1 / len(MODELS))


def transitions(filters: Filters, dt: float, config: MmaConfig) -> Floats:
    """(M, M) probability of the change from one mode (row) to another (column) within `dt` [s].

    A vehicle leaves its mode for either other one after `mode_time_s` on average. That it may stand depends on the
    state, as in Seah and Hwang (2009): a filter of a moving vehicle that says it is slow describes a standing one. Left
    to the likelihood, this could not be told: at speed 0 both filters predict the same.
    """
    leaves = 0.5 * -np.expm1(-dt / config.mode_time_s)
    stops = -np.expm1(-dt / config.stopping_time_s)
    chain = np.full((len(MODELS), len(MODELS)), leaves)
    stopping = stops * slow(filters, config.standing_mps)[[CV, CA]]
    chain[(CV, CA), STATIONARY] = np.maximum(stopping, LEAST_PROBABILITY)
    np.fill_diagonal(chain, 0.0)
    np.fill_diagonal(chain, 1.0 - chain.sum(axis=1))
    return chain


def slow(filters: Filters, limit_mps: float) -> Floats:
    """(M,) probability by each filter that the vehicle is slower than the limit, along the way it seems to go."""
    velocity, spread = filters.mean[:, 2:4], filters.covariance[:, 2:4, 2:4]
    speed = np.hypot(*velocity.T)
    moves = speed[:, None] > NO_SPEED_MPS
    way = np.where(moves, velocity / np.maximum(speed, NO_SPEED_MPS)[:, None], (1.0, 0.0))
    std = np.sqrt(np.einsum("mi,mij,mj->m", way, spread, way))
    return np.asarray(ndtr((limit_mps - speed) / std) - ndtr((-limit_mps - speed) / std))


def mix(filters: Filters, probability: Floats, chain: Floats) -> tuple[Filters, Floats]:
    """Let the filters start from what those believed that led to them; and (M,) the probabilities before (12).

    Bar-Shalom, Li, Kirubarajan (2001), 11.6.6: filter j starts from the mean and covariance of the mixture of all
    filters i, in the shares in which the vehicle came from i when it is in mode j now.
    """
    flow = probability[:, None] * chain
    prior = flow.sum(axis=0)
    share = flow / prior
    mean = share.T @ filters.mean
    off = filters.mean[:, None] - mean
    spread = filters.covariance[:, None] + off[..., :, None] * off[..., None, :]
    return Filters(mean, np.einsum("ij,ijkl->jkl", share, spread)), prior


def score(filters: Filters, residual: Floats, noise: Floats, tail_dof: float) -> tuple[Floats, float]:
    """(M,) logarithm of (11) for pre-fit residuals (M, 2) [m] of a measurement with covariance (2, 2).

    The paper prints S = H P H' in (10), which leaves out the measurement's own noise; S = H P H' + R here. In place of
    the normal density (11) it is Student's t of `tail_dof` degrees, of which the normal is the limit: now and then a
    corner jumps, from a bumper to a hood or where an occluder lets go of it, and one jump must not decide for a model.
    The second value is by how much the noise of this measurement is to be raised, as the nearest of the models tells:
    what scales the covariance in the t-distribution's mean of scale (Roth, Ozkan, Gustafsson 2013).
    """
    squared, determinant = mahalanobis(residual, filters.covariance[:, :2, :2] + noise)
    density = -0.5 * (tail_dof + 2) * np.log1p(squared / tail_dof) - 0.5 * np.log((2 * np.pi) ** 2 * determinant)
    return density, max(1.0, (tail_dof + float(squared.min())) / (tail_dof + 2))


def update(probability: Floats, evidence: Floats, floor: float = LEAST_PROBABILITY) -> Floats:
    """(M,) model probabilities after one observation, equation (12) in logarithms.

    Parameters
    ----------
    probability
        (M,) before the observation, all above 0.
    evidence
        (M,) logarithm of (11) under each model. A common offset cancels, so that no outlier can underflow.
    floor
        No probability falls below.
    """
    score = np.log(probability) + evidence
    posterior = np.exp(score - score.max())
    posterior = np.maximum(posterior / posterior.sum(), floor)
    return np.asarray(posterior / posterior.sum())

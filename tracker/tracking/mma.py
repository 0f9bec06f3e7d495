"""Multiple-model association: score the filters of a bank, equations (10) to (12).

The paper runs the filters independently, without mixing. After a manoeuvre its constant velocity filter is wrong for
seconds, and of no use when the vehicle returns to that mode. Here a vehicle may change its mode between two scans (a
Markov chain before (12)), and each filter starts a scan from the mixture of the filters that may have led to its mode
(Blom and Bar-Shalom 1988). The reported estimate is that of the paper: the filter of the highest score.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.records import MODEL_NAMES, MODELS
from luxloop.tracker.tracking.filters import Filters
from luxloop.tracker.tracking.kernels import multiple_models as kernel

LEAST_PROBABILITY = 1e-9
"""Lower limit of a model probability, which keeps its logarithm finite."""

STATIONARY, CV, CA = (MODELS.index(model) for model in ("stationary", "cv", "ca"))
"""Their indices in the standard set."""


STOPPING_TIME_S = 0.2
"""Time constant of the change from a moving model below that speed to the stationary one [s]."""


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
    tail_dof: float = 4.0
    """Degrees of freedom of the t-distribution of corner noise: few mean heavy tails, 1e6 is nearly normal."""
    probability_floor: float = 0.02
    """`paper` and `average`: lower limit of every probability, so that a model can recover at a change of mode."""

    def __post_init__(self) -> None:
        if not 0 < self.probability_floor < 1 / len(MODEL_NAMES):
            raise ValueError(f"probability_floor must lie between 0 and 1/{len(MODEL_NAMES)}")
        if self.mode_time_s < STOPPING_TIME_S:
            raise ValueError(f"mode_time_s is {self.mode_time_s}; give {STOPPING_TIME_S} or more")
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
    shape = filters.mean.shape[:-1]
    chain = kernel.transitions(*banks(filters), changes(dt, config, models))
    return np.asarray(chain.reshape(*shape, len(models)))


def changes(dt: float, config: MmaConfig, models: tuple[str, ...]) -> kernel.Changes:
    """Return the changes of the mode within `dt` [s]."""
    leaves = -math.expm1(-dt / config.mode_time_s) / max(len(models) - 1, 1)
    stops = -math.expm1(-dt / STOPPING_TIME_S)
    stationary = models.index("stationary") if "stationary" in models else -1
    return kernel.Changes(leaves, stops, stationary, config.standing_mps, LEAST_PROBABILITY)


def mix(filters: Filters, probability: Floats, chain: Floats) -> tuple[Filters, Floats]:
    """Return the mixed filters, and the model probabilities (..., M) before (12).

    Bar-Shalom, Li, Kirubarajan (2001), 11.6.6: filter j starts from the mean and covariance of the mixture of all
    filters i, weighted by the probability that the vehicle was in mode i if it is in mode j now.
    """
    models, modes = chain.shape[-2:]
    rows = probability.reshape(-1, models), chain.reshape(-1, models, modes)
    mean, covariance, prior = kernel.mix(*banks(filters), *rows)
    shape, n = (*probability.shape[:-1], modes), mean.shape[-1]
    return Filters(mean.reshape(*shape, n), covariance.reshape(*shape, n, n)), prior.reshape(shape)


def banks(filters: Filters) -> tuple[Floats, Floats]:
    """Return the means (T, M, n) and covariances (T, M, n, n) of filters (..., M)."""
    models, n = filters.mean.shape[-2:]
    return filters.mean.reshape(-1, models, n), filters.covariance.reshape(-1, models, n, n)


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
    models = residual.shape[-2]
    rows = residual.reshape(-1, models, 2), noise.reshape(-1, 2, 2)
    evidence, scale = kernel.score(banks(filters)[1], *rows, tail_dof)
    return evidence.reshape(residual.shape[:-1]), scale.reshape(noise.shape[:-2])


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
    models = probability.shape[-1]
    rows = probability.reshape(-1, models), evidence.reshape(-1, models)
    return np.asarray(kernel.update(*rows, floor).reshape(probability.shape))

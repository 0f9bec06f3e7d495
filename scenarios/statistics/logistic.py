"""Logistic regression of a binary outcome on one quantity, and its intervals from resampled clusters.

Firth's penalty (1993, Biometrika 80, 27) removes the bias of small samples and gives finite estimates also if the
outcome changes at one value without exception (Heinze and Schemper 2002, Statistics in Medicine 21, 2409).
"""

from dataclasses import dataclass

import numpy as np
import scipy

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.statistics.intervals import TAIL, Interval

RESAMPLES = 1000
SEED = 0
"""Seed of the resampling; fixed, so that the same data always have the same intervals."""
MOST_STEPS, TOLERANCE = 200, 1e-9
LONGEST_STEP = 1.0
"""Bound of a Newton step, in units of the standardised quantity: full steps may diverge far from the optimum."""


@dataclass(frozen=True, slots=True, eq=False)
class LogisticFit:
    """Fitted curves, a row per resample or a single one: P(outcome) = 1 / (1 + exp(-(intercept + slope x)))."""

    intercept: Floats
    """(B,)"""
    slope: Floats
    """(B,) per unit of x."""

    def share(self, x: Floats) -> Floats:
        """(B, K) probability of the outcome at values (K,)."""
        share: Floats = scipy.special.expit(self.intercept[:, None] + self.slope[:, None] * x)
        return share

    def value_at(self, share: float) -> Floats:
        """(B,) value at which the probability is `share`; infinite, in the direction of growth, without a slope."""
        with np.errstate(divide="ignore"):
            value: Floats = (scipy.special.logit(share) - self.intercept) / self.slope
        return value


def fit(x: Floats, outcome: Bools, weight: Floats | None = None) -> LogisticFit:
    """Maximise the penalised likelihood log L + 1/2 log det I by Newton's method.

    Parameters
    ----------
    x
        (n,) quantity; at least two different values.
    outcome
        (n,)
    weight
        (B, n) weights of the observations, a row per fit; default: one fit with weights 1.
    """
    weights = np.ones((1, len(x))) if weight is None else weight
    middle, scale = float(x.mean()), float(x.std()) or 1.0
    z, y = (x - middle) / scale, outcome.astype(np.float64)
    coefficients = np.zeros((len(weights), 2))
    for _ in range(MOST_STEPS):
        score, information = _score(coefficients, z, y, weights)
        step = np.linalg.solve(information, score[..., None])[..., 0]
        coefficients += np.clip(step, -LONGEST_STEP, LONGEST_STEP)
        if np.abs(step).max() < TOLERANCE:
            break
    slope = coefficients[:, 1] / scale
    return LogisticFit(coefficients[:, 0] - slope * middle, slope)


def _score(coefficients: Floats, z: Floats, y: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Return Firth's score (B, 2) and the information (B, 2, 2) of coefficients (B, 2)."""
    design = np.column_stack([np.ones_like(z), z])
    p = scipy.special.expit(coefficients @ design.T)
    w = weights * p * (1.0 - p)
    information = np.einsum("bn,ni,nj->bij", w, design, design) + 1e-12 * np.eye(2)
    inverse = np.linalg.inv(information)
    leverage = w * np.einsum("ni,bij,nj->bn", design, inverse, design)
    score = (weights * (y - p) + leverage * (0.5 - p)) @ design
    return score, information


def resampled(x: Floats, outcome: Bools, cluster: Ints) -> LogisticFit:
    """Return the fits of `RESAMPLES` samples of clusters, drawn with replacement.

    Parameters
    ----------
    cluster
        (n,) index of the cluster of each observation, from 0 on without gaps.
    """
    count = int(cluster.max()) + 1
    draws = np.random.default_rng(SEED).multinomial(count, np.full(count, 1.0 / count), RESAMPLES)
    return fit(x, outcome, draws[:, cluster].astype(np.float64))


def percentile_interval(values: Floats) -> Interval:
    """Return the 95 % percentile interval of resampled values (B,); infinite values are allowed."""
    low, high = np.quantile(values, (TAIL, 1.0 - TAIL), method="nearest")
    return float(low), float(high)

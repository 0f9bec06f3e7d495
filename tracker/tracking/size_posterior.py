"""Posterior probabilities of a vehicle's length and width, from the extents of its views and from vehicle classes.

Bayes' rule over a grid of sizes. Length and width of one class are independent; the class connects them, so that a wide
front belongs to a long vehicle.
"""

import math

import numpy as np
from numba import njit

from tracker.arrays import Bools, Floats
from tracker.tracking.size_likelihood import LOG_ODDS_MAX, add_view, average_pieces
from tracker.tracking.vehicle_sizes import GRID_M, side_probabilities

_SHARE, _PRIOR = side_probabilities()


class SizePosterior:
    """Log-likelihoods and posterior probabilities of the sides of `GRID_M`.

    Parameters
    ----------
    view_correlation
        Correlation of the views of one side, which is the minimum weight of a view.
    forgetting
        Share of the earlier evidence that a view of the whole side replaces.
    truncated, merged
        Probabilities that a side that seems whole is truncated, and that a view is merged with another object.
    hidden
        (2,) part of length and width that rounded corners hide [m].
    """

    def __init__(
        self, view_correlation: float, forgetting: float, truncated: float, merged: float, hidden: Floats
    ) -> None:
        self._view_correlation, self._forgetting = view_correlation, forgetting
        self._truncated, self._merged, self._hidden = truncated, merged, hidden
        self._log_likelihood = np.zeros((2, len(GRID_M)))
        self._of_pieces = np.zeros((2, len(GRID_M)))
        """Mean log-likelihoods of the truncated views: all of them together have the evidence of one."""
        self._views, self._cut_views = np.zeros(2, dtype=np.int64), np.zeros(2, dtype=np.int64)
        self._estimate()

    def observe(self, observed: Floats, whole: Bools, visible: Bools) -> None:
        """Add a view of extents (2,) [m], with masks (2,) of sides truncated at neither end, and of `visible` ones."""
        self._views += visible
        weight = np.where(visible, np.maximum(1.0 / np.maximum(self._views, 1), self._view_correlation), 0.0)
        forgetting = np.where(visible & whole, self._forgetting, 0.0)
        self._add(observed, whole, weight, forgetting)
        cut = visible & ~whole
        self._cut_views = np.minimum(self._cut_views + cut, round(1.0 / self._forgetting))
        average_pieces(self._of_pieces, observed, cut / np.maximum(self._cut_views, 1), self._hidden, self._merged)
        self._estimate()

    def exceed(self, extents: Floats) -> None:
        """Exclude sides shorter than extents (2,) [m], which other evidence than a single view shows."""
        weight = np.full(2, LOG_ODDS_MAX)
        self._add(extents, np.zeros(2, np.bool_), weight, np.zeros(2))
        self._estimate()

    def turn(self, quarters: int) -> None:
        """Rename the sides for a heading turned by `quarters`."""
        if quarters % 2:
            self._log_likelihood, self._of_pieces = self._log_likelihood[::-1].copy(), self._of_pieces[::-1].copy()
            self._views, self._cut_views = self._views[::-1].copy(), self._cut_views[::-1].copy()
            self._estimate()

    def _add(self, observed: Floats, whole: Bools, weight: Floats, forgetting: Floats) -> None:
        """Add a view to the log-likelihoods of independent views."""
        shares = (self._truncated, self._merged)
        add_view(self._log_likelihood, observed, whole, weight, forgetting, self._hidden, *shares)

    def _estimate(self) -> None:
        self.size, self.std = estimate(self._log_likelihood + self._of_pieces, _SHARE, _PRIOR)


@njit(cache=True)
def estimate(log_likelihood: Floats, share: Floats, prior: Floats) -> tuple[Floats, Floats]:
    """Return the sides (2,) of the greatest expected overlap, and standard deviations (2,) about them [m]."""
    probability = posterior(log_likelihood, share, prior)
    size, std = np.empty(2), np.empty(2)
    for axis in range(2):
        size[axis] = side_of_greatest_overlap(probability[axis])
        std[axis] = math.sqrt(np.sum(probability[axis] * (GRID_M - size[axis]) ** 2))
    return size, std


@njit(cache=True)
def posterior(log_likelihood: Floats, share: Floats, prior: Floats) -> Floats:
    """(2, G) probabilities of the sides of `GRID_M`, from shares (C,) and probabilities (C, 2, G) of the classes."""
    joint = prior * np.exp(log_likelihood)
    result, total = np.zeros_like(log_likelihood), 0.0
    for kind in range(len(share)):
        length, width = joint[kind, 0].sum(), joint[kind, 1].sum()
        result[0] += share[kind] * width * joint[kind, 0]
        result[1] += share[kind] * length * joint[kind, 1]
        total += share[kind] * length * width
    return result / total


@njit(cache=True)
def side_of_greatest_overlap(probability: Floats) -> float:
    """Side a [m] with the greatest expected overlap min(a, b) / max(a, b) with the true one b, from a common end.

    In a narrow posterior, the mean of its neighbourhood refines the grid.
    """
    shorter, longer = 0.0, np.sum(probability / GRID_M)
    best, place = -1.0, 0
    for g in range(len(GRID_M)):
        shorter += probability[g] * GRID_M[g]
        longer -= probability[g] / GRID_M[g]
        overlap = shorter / GRID_M[g] + longer * GRID_M[g]
        if overlap > best:
            best, place = overlap, g
    near = probability[max(place - 4, 0) : place + 5]
    if near.sum() < 0.5:
        return float(GRID_M[place])
    return float(np.sum(near * GRID_M[max(place - 4, 0) : place + 5]) / near.sum())

"""Likelihoods of the sides of a vehicle, from the extents of its views."""

import math

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.compiled import kernel
from luxloop.tracker.tracking.vehicle_sizes import GRID_M

HIDDEN_STD_M = 0.12
"""Standard deviation of the part of a side that rounded corners hide [m]: bodies differ, and ends have few points."""

SIZE_STD_SHARE = 0.02
"""Standard deviation of an extent that grows with the side, as a share of it: errors of heading and beam spacing."""

STD_M: Floats = np.hypot(HIDDEN_STD_M, SIZE_STD_SHARE * GRID_M)
"""(G,) standard deviation of the extent of each side of `GRID_M` [m]."""

NEGLIGIBLE_SIGMA = 12.0
"""Misfit in standard deviations beyond which a normal density is below the rounding errors of the other densities."""

MARGIN_M = 0.1
"""Errors of range and heading by which a piece may exceed its side [m]."""

WHOLE_SHARE = 0.3
"""Share of the sides that count as truncated, but are visible from end to end."""

LOG_ODDS_MAX = 15.0
"""Maximum log-odds of one size against another, so that later views can correct it."""


@kernel()
def whole_density(extent: float, g: int, hidden: float) -> float:
    """Density [1/m] of the visible extent [m] of a whole side `GRID_M[g]`, of which a part is `hidden` [m]."""
    misfit = (extent - (GRID_M[g] - hidden)) / STD_M[g]
    if abs(misfit) > NEGLIGIBLE_SIGMA:
        return 0.0
    return float(math.exp(-0.5 * misfit * misfit) / (STD_M[g] * math.sqrt(2.0 * math.pi)))


@kernel()
def add_view(
    log_likelihood: Floats,
    observed: Floats,
    whole: Bools,
    weight: Floats,
    forgetting: Floats,
    hidden: Floats,
    truncated: float,
    merged: float,
) -> None:
    """Add a view of extents (2,) [m] to log-likelihoods (2, G), in place.

    A whole side shows its length but for what its corners hide, or a piece of it if it is `truncated` by something that
    was not detected. A truncated side is a lower bound. A `merged` view has any extent.
    """
    for axis in range(2):
        if weight[axis] == 0.0:
            continue
        highest, of_merged = -np.inf, math.log(merged)
        for g in range(len(GRID_M)):
            fits = observed[axis] < GRID_M[g] + MARGIN_M
            if whole[axis]:
                seen = whole_density(observed[axis], g, hidden[axis])
                piece = truncated / GRID_M[g] if fits else 0.0
                log_density = math.log((1.0 - truncated) * seen + piece + merged / GRID_M[-1])
            else:
                log_density = 0.0 if fits else of_merged
            value = (1.0 - forgetting[axis]) * log_likelihood[axis, g] + weight[axis] * log_density
            log_likelihood[axis, g] = value
            highest = max(highest, value)
        for g in range(len(GRID_M)):
            log_likelihood[axis, g] = max(log_likelihood[axis, g] - highest, -LOG_ODDS_MAX)


@kernel()
def average_pieces(mean: Floats, observed: Floats, gain: Floats, hidden: Floats, merged: float) -> None:
    """Average a truncated view of extents (2,) [m] into mean log-likelihoods (2, G), in place.

    The side shows a piece of any length, or all of it: an occluder or a gap between units that ends beside it counts as
    truncation, too. The views of a scene that stands still are one view, so they are averaged, with gains (2,).
    """
    for axis in range(2):
        if gain[axis] == 0.0:
            continue
        for g in range(len(GRID_M)):
            piece = (1.0 - WHOLE_SHARE) / GRID_M[g] if observed[axis] < GRID_M[g] + MARGIN_M else 0.0
            seen = whole_density(observed[axis], g, hidden[axis])
            log_density = math.log(piece + WHOLE_SHARE * seen + merged / GRID_M[-1])
            mean[axis, g] += gain[axis] * (log_density - mean[axis, g])

"""Free space: places that the beams of all units pass, without the positions of the units.

A unit is within a known distance of the ego's centre. Its bearing of a place then differs from that of the centre by a
known angle at most. If all returns in this window of bearings are farther than the place, nothing is there.
"""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Floats32
from luxloop.compiled import kernel

BINS = 512
"""Bins of bearing, 0.7 degrees each: a beam of a layer or two."""

COVERED = 0.5
"""Minimum fraction of a window's bins with a return: open sky says nothing."""

UNIT_OFFSET_M = 2.5
"""Maximum distance of a unit from the ego's centre [m], the margin for statements on the view of all units: half the
length of a car."""


@kernel()
def free(places: Floats, returns: Floats, margin_m: float) -> Bools:
    """(C,) mask of places that all returns near their bearing lie behind.

    Parameters
    ----------
    places
        (C, 2) relative to the ego's centre [m].
    returns
        (N, 2) all points of a scan relative to the ego's centre [m]; those within `UNIT_OFFSET_M` are ignored.
    margin_m
        Minimum distance of returns behind a place [m].
    """
    nearest = profile(returns)
    passed = np.empty(len(places), np.bool_)
    for c in range(len(places)):
        passed[c] = is_free(places[c, 0], places[c, 1], nearest, margin_m)
    return passed


@kernel()
def is_free(x: float, y: float, nearest: Floats, margin_m: float) -> bool:
    """Return True if the nearest returns (BINS,) of all bearings at which a unit may see a place are behind it."""
    range_m = elementary.hypot(x, y)
    if range_m <= UNIT_OFFSET_M:
        return False
    half = elementary.asin(UNIT_OFFSET_M / range_m)
    bins = max(1, math.ceil(half / math.pi * BINS))
    first = math.floor((elementary.atan2(y, x) - half) / (2.0 * math.pi) * BINS)
    covered = 0
    for k in range(first, first + bins):
        if nearest[k % BINS] <= range_m + margin_m:
            return False
        covered += math.isfinite(nearest[k % BINS])
    return covered >= COVERED * bins


@kernel()
def profile(returns: Floats) -> Floats:
    """(BINS,) range of the nearest return by bearing [m], infinite without one."""
    nearest = np.full(BINS, np.inf)
    for i in range(len(returns)):
        x, y = returns[i, 0], returns[i, 1]
        range_m = elementary.hypot(x, y)
        if range_m > UNIT_OFFSET_M:
            k = math.floor(elementary.atan2(y, x) / (2.0 * math.pi) * BINS) % BINS
            nearest[k] = min(nearest[k], range_m)
    return nearest


@kernel()
def turned_returns(points: Floats32, turn: float) -> Floats:
    """(K, 2) x and y of the finite ones of points (N, 3), rotated by an angle [rad]."""
    cos, sin, count = elementary.cos(turn), elementary.sin(turn), 0
    turned = np.empty((len(points), 2))
    for i in range(len(points)):
        x, y, z = points[i]
        if math.isfinite(x) and math.isfinite(y) and math.isfinite(z):
            turned[count, 0], turned[count, 1] = cos * x - sin * y, sin * x + cos * y
            count += 1
    return turned[:count]

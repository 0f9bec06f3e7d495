"""Free space: places that the beams of all units pass, without the positions of the units.

A unit is within a known distance of the ego's centre. Its bearing of a place then differs from that of the centre by a
known angle at most. If all returns in this window of bearings are farther than the place, nothing is there.
"""

import numpy as np

from tracker.arrays import Bools, Floats, Ints

BINS = 512
"""Bins of bearing, 0.7 degrees each: a beam of a layer or two."""

COVERED = 0.5
"""Minimum share of a window's bins with a return: open sky says nothing."""


def seen_through(places: Floats, returns: Floats, unit_offset_m: float, margin_m: float) -> Bools:
    """(C,) mask of places that all returns near their bearing lie behind.

    Parameters
    ----------
    places
        (C, 2) relative to the ego's centre [m].
    returns
        (N, 2) all points of a scan relative to the ego's centre [m]; those within `unit_offset_m` are ignored.
    unit_offset_m
        Maximum distance of a unit from the ego's centre [m].
    margin_m
        Minimum distance of returns behind a place [m].
    """
    nearest = profile(returns, unit_offset_m)
    table, count = window_minima(nearest), np.append(0, np.cumsum(np.isfinite(np.tile(nearest, 2))))
    range_m = np.hypot(*places.T)
    outside = range_m > unit_offset_m
    half = np.arcsin(np.where(outside, unit_offset_m / np.where(outside, range_m, 1.0), 1.0))
    bins = np.maximum(1, np.ceil(half / np.pi * BINS)).astype(np.int64)
    first = (np.floor((np.arctan2(places[:, 1], places[:, 0]) - half) / (2 * np.pi) * BINS).astype(np.int64)) % BINS
    level = np.floor(np.log2(bins)).astype(np.int64)
    last = (first + bins - (1 << level)) % BINS
    farther = np.minimum(table[level, first], table[level, last]) > range_m + margin_m
    covered = count[first + bins] - count[first] >= COVERED * bins
    return np.asarray(outside & farther & covered)


def profile(returns: Floats, unit_offset_m: float) -> Floats:
    """(BINS,) range of the nearest return by bearing [m], infinite without one."""
    nearest = np.full(BINS, np.inf)
    range_m = np.hypot(*returns.T)
    bin_of: Ints = np.floor(np.arctan2(returns[:, 1], returns[:, 0]) / (2 * np.pi) * BINS).astype(np.int64) % BINS
    far = range_m > unit_offset_m
    np.minimum.at(nearest, bin_of[far], range_m[far])
    return nearest


def window_minima(nearest: Floats) -> Floats:
    """(L, BINS) minimum over the 2**level bins that start at each bin, round the circle."""
    table = [nearest]
    for level in range(int(np.log2(BINS))):
        table.append(np.minimum(table[-1], np.roll(table[-1], -(1 << level))))
    return np.array(table)

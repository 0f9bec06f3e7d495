"""Reference implementations of the kernels of boxes and free space: the same equations in plain numpy."""

import numpy as np

from luxloop.tracker.free_space import BINS, COVERED, UNIT_OFFSET_M
from luxloop.tracker.geometry import rotate


def inside(points, center, heading, size):
    """(P, B) mask of points (P, 2) inside boxes with centre (B, 2), heading (B,) and size (B, 2)."""
    box_frame = rotate(points[:, None] - center, -heading)
    return np.all(np.abs(box_frame) <= 0.5 * size, axis=2)


def projected_size(size, turn):
    """(2,) extent of a box of size (2,) along and across a heading that differs from its own by `turn` [rad]."""
    cos, sin = abs(np.cos(turn)), abs(np.sin(turn))
    return np.array([[cos, sin], [sin, cos]]) @ size


def hull(pieces, a, b):
    """Return the low and high corner (2,) of the box around two pieces, in the frame of the first [m]."""
    away = rotate(pieces.center[b] - pieces.center[a], -pieces.heading[a])
    other = projected_size(pieces.size[b], pieces.heading[b] - pieces.heading[a])
    low, high = np.minimum(-pieces.size[a], 2 * away - other), np.maximum(pieces.size[a], 2 * away + other)
    return 0.5 * low, 0.5 * high


def free(places, returns, margin_m):
    """(C,) mask of places that all returns near their bearing lie behind."""
    nearest = profile(returns)
    table, count = window_minima(nearest), np.append(0, np.cumsum(np.isfinite(np.tile(nearest, 2))))
    range_m = np.hypot(*places.T)
    outside = range_m > UNIT_OFFSET_M
    half = np.arcsin(np.where(outside, UNIT_OFFSET_M / np.where(outside, range_m, 1.0), 1.0))
    bins = np.maximum(1, np.ceil(half / np.pi * BINS)).astype(np.int64)
    first = np.floor((np.arctan2(places[:, 1], places[:, 0]) - half) / (2 * np.pi) * BINS).astype(np.int64) % BINS
    level = np.floor(np.log2(bins)).astype(np.int64)
    last = (first + bins - (1 << level)) % BINS
    farther = np.minimum(table[level, first], table[level, last]) > range_m + margin_m
    covered = count[first + bins] - count[first] >= COVERED * bins
    return outside & farther & covered


def profile(returns):
    """(BINS,) range of the nearest return by bearing [m], infinite without one."""
    nearest = np.full(BINS, np.inf)
    range_m = np.hypot(*returns.T)
    bin_of = np.floor(np.arctan2(returns[:, 1], returns[:, 0]) / (2 * np.pi) * BINS).astype(np.int64) % BINS
    far = range_m > UNIT_OFFSET_M
    np.minimum.at(nearest, bin_of[far], range_m[far])
    return nearest


def window_minima(nearest):
    """(L, BINS) minimum over the 2**level bins that start at each bin, round the circle."""
    table = [nearest]
    for level in range(int(np.log2(BINS))):
        table.append(np.minimum(table[-1], np.roll(table[-1], -(1 << level))))
    return np.array(table)

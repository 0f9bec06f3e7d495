"""Kernels of the start of the search for a body: headings, visible sides, first depths, and points by scan line."""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.faces import EGO_REACH

QUARTER = 0.5 * math.pi
APART = math.radians(2.0)
"""Minimum difference of two starts [rad]; nearer ones lead to the same result."""
STARTS_MAX = 3
"""Maximum number of starts; more find no better result."""


@njit(cache=True)
def quarter_difference(a: float, b: float) -> float:
    """Return the difference of two headings modulo a quarter turn, in [-pi/4, pi/4] [rad]."""
    turn = (a - b) / QUARTER
    return QUARTER * (turn - math.floor(turn + 0.5))


@njit(cache=True)
def visible_sides(place: Floats) -> Floats:
    """Return the sides (1 or 2,) that may face the ego, on an axis through it with points at `place` (N,).

    Units at different ends of the ego may see either side of a body beside it.
    """
    mean = place.mean()
    return np.array([1.0, -1.0]) if abs(mean) < EGO_REACH else np.array([1.0 if mean > 0.0 else -1.0])


@njit(cache=True)
def distinct_starts(heading: Floats, cost: Floats) -> Ints:
    """Return up to `STARTS_MAX` of the headings (M,) that are apart from each other, cheapest first."""
    kept, count = np.empty(STARTS_MAX, np.int64), 0
    for m in np.argsort(cost, kind="mergesort"):
        apart = count < STARTS_MAX
        for j in range(count):
            apart = apart and abs(quarter_difference(heading[m], heading[kept[j]])) > APART
        if apart:
            kept[count] = m
            count += 1
    return kept[:count]


@njit(cache=True)
def directions(points: Floats) -> Floats:
    """(N, 2) unit vectors from the ego to points."""
    ray = np.empty_like(points)
    for i in range(len(points)):
        ray[i] = points[i] / max(math.hypot(points[i, 0], points[i, 1]), 1e-6)
    return ray


@njit(cache=True)
def line_starts(line: Ints) -> Ints:
    """(G + 1,) first point of each of the G scan lines of points in the order of their lines `line` (N,), and N."""
    start, count = np.zeros(len(line) + 1, np.int64), 0
    for i in range(1, len(line)):
        if line[i] != line[i - 1]:
            count += 1
            start[count] = i
    start[count + 1] = len(line)
    return start[: count + 2]


@njit(cache=True)
def shallow_depth(place: Floats, rank: int) -> float:
    """Return the value that `rank` others of `place` (N,) are below, or equal to; ranks are small."""
    least, count = np.empty(rank + 1), 0
    for value in place:
        if count <= rank or value < least[rank]:
            at = min(count, rank)
            while at > 0 and least[at - 1] > value:
                least[at] = least[at - 1]
                at -= 1
            least[at] = value
            count = min(count + 1, rank + 1)
    return float(least[rank])

"""Kernels of the start of the search for a body: headings, visible sides, first depths, and points by scan line."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.bowed_faces import STATES
from luxloop.tracker.detection.kernels.faces import EGO_REACH

QUARTER = 0.5 * math.pi
APART = math.radians(2.0)
"""Minimum difference of two starts [rad]; nearer ones lead to the same result."""
STARTS_MAX = 3
"""Maximum number of starts; more find no better result."""
HYPOTHESES_MAX = 8 * STARTS_MAX
"""Two places of the flank for each of up to four corners of a body beside the ego."""
SHALLOW_SHARE = 0.08
"""Share of the points in front of a face at its start: mirrors and range outliers."""
COST, HEADING_VARIANCE, SIDE, FLANK, STATE = 0, 1, 2, 4, 5
"""Columns of a hypothesis (STATE + STATES,): cost, variance of the heading [rad^2], sides (2,), flank, and state."""


@kernel(error_model="numpy")
def quarter_difference(a: float, b: float) -> float:
    """Return the difference of two headings modulo a quarter turn, in [-pi/4, pi/4] [rad]."""
    turn = (a - b) / QUARTER
    return QUARTER * (turn - math.floor(turn + 0.5))


@kernel(error_model="numpy")
def distinct_starts(heading: Floats, order: Ints, starts: Floats) -> int:
    """Write up to `STARTS_MAX` of the headings (M,) that are apart from each other, in this order; return their number.

    `order` (M,) begins with the cheapest heading.
    """
    count = 0
    for m in order:
        apart = count < STARTS_MAX
        for j in range(count):
            apart = apart and abs(quarter_difference(heading[m], starts[j])) > APART
        if apart:
            starts[count] = heading[m]
            count += 1
    return count


@kernel(error_model="numpy")
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


@kernel(error_model="numpy")
def shallow_depths(points: Floats, center: Floats, heading: float, depth: Floats) -> None:
    """Write the depth (2, 2) of flat faces along and across a heading, each on the low and on the high side.

    Depths are about the `center` (2,), on the low side of an axis first; infinite for a side that does not face the
    ego. Units at different ends of the ego may see either side of a body beside it.
    """
    cos, sin, place = math.cos(heading), math.sin(heading), np.empty(len(points))
    for face in range(2):
        total = 0.0
        for i in range(len(points)):
            x, y = points[i, 0], points[i, 1]
            total += cos * y - sin * x if face == 0 else cos * x + sin * y
        mean = total / len(points)
        for high in range(2):
            sign = 1.0 - 2.0 * high
            if abs(mean) >= EGO_REACH and (mean > 0.0) != (sign > 0.0):
                depth[face, high] = np.inf
                continue
            for i in range(len(points)):
                x, y = points[i, 0] - center[0], points[i, 1] - center[1]
                place[i] = sign * (cos * y - sin * x if face == 0 else cos * x + sin * y)
            depth[face, high] = shallow_depth(place, int(SHALLOW_SHARE * len(points)))


@kernel(error_model="numpy")
def first_hypotheses(points: Floats, offset: Ints, center: Floats, heading: Floats, order: Ints) -> tuple[Floats, Ints]:
    """Return hypotheses (H, STATE + STATES) of bodies with flat faces, and the segment of each (H,).

    Each has one of the best headings of its segment, one pair of visible sides, and one place of the flank.

    Parameters
    ----------
    points, offset
        (N, 2) grouped by segment [m]; (S + 1,) first point of each segment, and N.
    center
        (S, 2) origin of the states [m].
    heading, order
        (S, M) candidates [rad], and their indices, the cheapest first.
    """
    found, count = np.zeros((HYPOTHESES_MAX * len(heading), STATE + STATES)), 0
    owner = np.empty(len(found), np.int64)
    starts, depth = np.empty(STARTS_MAX), np.empty((2, 2))
    for s in range(len(heading)):
        own = points[offset[s] : offset[s + 1]]
        for k in range(distinct_starts(heading[s], order[s], starts)):
            shallow_depths(own, center[s], starts[k], depth)
            for corner in range(8):
                high_0, high_1, flank = corner // 4, corner // 2 % 2, corner % 2
                if depth[0, high_0] < np.inf and depth[1, high_1] < np.inf:
                    found[count, SIDE], found[count, SIDE + 1] = 1.0 - 2.0 * high_0, 1.0 - 2.0 * high_1
                    found[count, FLANK], found[count, STATE] = flank, starts[k]
                    found[count, STATE + 1], found[count, STATE + 4] = depth[0, high_0], depth[1, high_1]
                    owner[count] = s
                    count += 1
    return found[:count], owner[:count]


@kernel(error_model="numpy")
def directions(points: Floats) -> Floats:
    """(N, 2) unit vectors from the ego to points (N, 2)."""
    ray = np.empty((len(points), 2))
    for i in range(len(points)):
        range_m = max(math.hypot(points[i, 0], points[i, 1]), 1e-6)
        ray[i, 0], ray[i, 1] = points[i, 0] / range_m, points[i, 1] / range_m
    return ray


@kernel(error_model="numpy")
def line_starts(line: Ints) -> Ints:
    """(G + 1,) first point of each of the G scan lines of points in the order of their lines `line` (N,), and N."""
    start, count = np.zeros(len(line) + 1, np.int64), 0
    for i in range(1, len(line)):
        if line[i] != line[i - 1]:
            count += 1
            start[count] = i
    start[count + 1] = len(line)
    return start[: count + 2]

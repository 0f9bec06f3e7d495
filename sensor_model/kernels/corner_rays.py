"""Entry of a whole beam into a convex solid, decided by its four corner rays and its planes as far as possible.

Over the rays of a beam, the inverse depth of the entry is concave and that of the exit is convex, as minimum and
maximum of linear functions. Corner rays that enter through one plane therefore decide all rays between them, and the
tangent at a corner bounds the depth inside the solid at all others.

Arguments `entry`, `entry_plane` and `leave` are as set by `slab_entry.split_planes`, `facing` and `hidden` are their
numbers of planes. `cos` and `sin` are of the largest azimuth of a ray from the centre of its beam, `low` and `high` are
the slopes of the lowest and highest rays of the beam.
"""

import math

from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import NONE

MISSED = -2
"""Result of `entry_of_corners` if no ray of the beam enters the solid."""


@kernel(error_model="numpy", inline="always")
def entry_of_corners(
    facing: int, hidden: int, entry: Floats, leave: Floats, cos: float, sin: float, low: float, high: float
) -> int:
    """Return the row of `entry` through which all rays of a beam enter a solid, MISSED, or NONE if undecided."""
    in0 = in1 = in2 = in3 = math.inf
    out0 = out1 = out2 = out3 = -math.inf
    at0 = at1 = at2 = at3 = 0
    by0 = by1 = by2 = by3 = 0
    for k in range(facing):
        centre, turn, down, up = cos * entry[k, 0], sin * entry[k, 1], low * entry[k, 2], high * entry[k, 2]
        right, left = centre - turn, centre + turn
        d0, d1, d2, d3 = right + down, right + up, left + down, left + up
        at0, in0 = k if d0 < in0 else at0, min(in0, d0)
        at1, in1 = k if d1 < in1 else at1, min(in1, d1)
        at2, in2 = k if d2 < in2 else at2, min(in2, d2)
        at3, in3 = k if d3 < in3 else at3, min(in3, d3)
    for k in range(hidden):
        centre, turn, down, up = cos * leave[k, 0], sin * leave[k, 1], low * leave[k, 2], high * leave[k, 2]
        right, left = centre - turn, centre + turn
        d0, d1, d2, d3 = right + down, right + up, left + down, left + up
        by0, out0 = k if d0 > out0 else by0, max(out0, d0)
        by1, out1 = k if d1 > out1 else by1, max(out1, d1)
        by2, out2 = k if d2 > out2 else by2, max(out2, d2)
        by3, out3 = k if d3 > out3 else by3, max(out3, d3)
    hits = (in0 > out0) + (in1 > out1) + (in2 > out2) + (in3 > out3)
    result = NONE
    if hits == 4:
        result = at0 if at0 == at1 and at0 == at2 and at0 == at3 else NONE
    elif hits == 0:
        wide, tall = 2.0 * sin, high - low
        # From a corner to another ray of the beam, the depth inside the solid grows at most by its slopes there.
        wider0, taller0 = wide * (entry[at0, 1] - leave[by0, 1]), tall * (entry[at0, 2] - leave[by0, 2])
        wider1, taller1 = wide * (entry[at1, 1] - leave[by1, 1]), tall * (leave[by1, 2] - entry[at1, 2])
        wider2, taller2 = wide * (leave[by2, 1] - entry[at2, 1]), tall * (entry[at2, 2] - leave[by2, 2])
        wider3, taller3 = wide * (leave[by3, 1] - entry[at3, 1]), tall * (leave[by3, 2] - entry[at3, 2])
        most0 = in0 - out0 + max(0.0, wider0) + max(0.0, taller0)
        most1 = in1 - out1 + max(0.0, wider1) + max(0.0, taller1)
        most2 = in2 - out2 + max(0.0, wider2) + max(0.0, taller2)
        most3 = in3 - out3 + max(0.0, wider3) + max(0.0, taller3)
        if min(min(most0, most1), min(most2, most3)) <= 0.0:
            result = MISSED
    return result


@kernel(error_model="numpy", inline="always")
def keep_relevant(
    facing: int, hidden: int, entry: Floats, entry_plane: Ints, leave: Floats, cos: float, sin: float, low: float,
    high: float,
) -> tuple[int, int, float]:  # fmt: skip
    """Move the planes that decide entry or exit of any ray of a beam to the front.

    Returns
    -------
    Number of planes kept in `entry` and in `leave`, and an upper bound of the inverse depth of the entry [1/m].
    """
    nearest, farthest = math.inf, -math.inf
    for p in range(facing):
        _, most = depth_bounds(entry[p, 0], entry[p, 1], entry[p, 2], cos, sin, low, high)
        nearest = min(nearest, most)
    for p in range(hidden):
        least, _ = depth_bounds(leave[p, 0], leave[p, 1], leave[p, 2], cos, sin, low, high)
        farthest = max(farthest, least)
    entries, exits = 0, 0
    for p in range(facing):
        c, s, t, q = entry[p, 0], entry[p, 1], entry[p, 2], entry_plane[p]
        least, _ = depth_bounds(c, s, t, cos, sin, low, high)
        if least <= nearest:
            for axis in range(3):
                entry[p, axis] = entry[entries, axis]
            entry_plane[p], entry_plane[entries] = entry_plane[entries], q
            entry[entries, 0], entry[entries, 1], entry[entries, 2] = c, s, t
            entries += 1
    for p in range(hidden):
        c, s, t = leave[p, 0], leave[p, 1], leave[p, 2]
        _, most = depth_bounds(c, s, t, cos, sin, low, high)
        if most >= farthest:
            for axis in range(3):
                leave[p, axis] = leave[exits, axis]
            leave[exits, 0], leave[exits, 1], leave[exits, 2] = c, s, t
            exits += 1
    return entries, exits, nearest


@kernel()
def depth_bounds(
    per_cos: float, per_sin: float, per_slope: float, cos: float, sin: float, low: float, high: float
) -> tuple[float, float]:
    """Return the least and the largest inverse depth of a plane over the rays of a beam [1/m]."""
    turn, down, up = abs(sin * per_sin), low * per_slope, high * per_slope
    return cos * per_cos - turn + min(down, up), cos * per_cos + turn + max(down, up)

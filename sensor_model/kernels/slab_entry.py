"""Entry of the rays of one azimuth into a convex solid n . p <= d, by the slab method.

A ray c f + s l + t u from o hits a plane at the inverse depth n . (c f + s l + t u) / (d - n . o), linear in its
cosine c, sine s and slope t. It enters a solid at the least inverse depth of the planes that o is outside of. It hits
the solid if that is more than the inverse depth of each plane that o is inside of. No ray needs a division.

Over the rays of a beam, the entry is concave and the exit is convex. Four corner rays that enter through one plane
therefore decide all rays between them, and a concave bound can prove that all rays pass a solid.

The functions are inlined, because a call costs an atomic reference count per array.
"""

import math

from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.records import NONE

MISSED, CROSSED = -1, -2
"""Results of `entry_of_corners` other than a plane: no ray of the beam enters the solid, or an edge crosses it."""
_ON_PLANE = 1e-300  # distance inside of an origin on a plane: the ray leaves at once, and no division by zero occurs


@njit(cache=True, error_model="numpy", inline="always")
def start_rays(
    k: int, layer: int, line: Floats, side: Floats, slope: Floats, far: Floats, depth: Floats, plane: Ints
) -> None:
    """Let the rays of the beam of a layer at azimuth k end on the ground or at the maximum range.

    Parameters
    ----------
    line, side, slope, far
        As in `records.Rays`.
    depth
        (L, R) out: inverse depth per ray of its nearest hit [1/m].
    plane
        (L, R) out: plane per ray of its nearest hit, or NONE.
    """
    per_cos, per_sin, per_slope = -line[5, k] / line[2, k], -line[8, k] / line[2, k], -line[11, k] / line[2, k]
    for r in range(side.shape[1]):
        at = side[0, r] * per_cos + side[1, r] * per_sin + slope[k, layer, r] * per_slope
        depth[layer, r] = max(at, far[k, layer, r])
        plane[layer, r] = NONE


@njit(cache=True, error_model="numpy", inline="always")
def split_planes(
    planes: Floats, begin: int, stop: int, local: Floats, c: int, entry: Floats, entry_plane: Ints, leave: Floats
) -> tuple[int, int]:
    """Split planes [begin, stop) into those that the origin of azimuth c is outside of and those that it is inside of.

    Parameters
    ----------
    local
        (12, C) lines in the frame of the body: origin, forward, left, up.
    entry, leave
        (K, 3) out: inverse depth per cosine, sine and slope of the planes outside of which, and inside of which, it is.
    entry_plane
        (K,) out: planes of `entry`.

    Returns
    -------
    Number of each.
    """
    x, y, z = local[0, c], local[1, c], local[2, c]
    fx, fy, fz = local[3, c], local[4, c], local[5, c]
    lx, ly, lz = local[6, c], local[7, c], local[8, c]
    ux, uy, uz = local[9, c], local[10, c], local[11, c]
    facing, hidden = 0, 0
    for q in range(begin, stop):
        nx, ny, nz = planes[q, 0], planes[q, 1], planes[q, 2]
        inward = planes[q, 3] - nx * x - ny * y - nz * z
        inward = inward if inward != 0.0 else _ON_PLANE
        per_metre = 1.0 / inward
        per_cos, per_sin = (nx * fx + ny * fy + nz * fz) * per_metre, (nx * lx + ny * ly + nz * lz) * per_metre
        per_slope = (nx * ux + ny * uy + nz * uz) * per_metre
        if inward < 0.0:
            entry[facing, 0], entry[facing, 1], entry[facing, 2], entry_plane[facing] = per_cos, per_sin, per_slope, q
            facing += 1
        else:
            leave[hidden, 0], leave[hidden, 1], leave[hidden, 2] = per_cos, per_sin, per_slope
            hidden += 1
    return facing, hidden


@njit(cache=True, error_model="numpy", inline="always")
def entry_of_corners(
    facing: int, hidden: int, entry: Floats, leave: Floats, cos: float, sin: float, low: float, high: float
) -> int:
    """Return the row of `entry` through which all rays of a beam enter a solid, or MISSED, or CROSSED if undecided.

    Parameters
    ----------
    cos, sin
        Of the largest azimuth of a ray from the centre of its beam.
    low, high
        Slopes of the lowest and highest rays of the beam.
    """
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
    result = CROSSED
    if hits == 4:
        result = at0 if at0 == at1 and at0 == at2 and at0 == at3 else CROSSED
    elif hits == 0:
        wide, tall = 2.0 * sin, high - low
        if (
            in0 - out0 + _gain(entry, at0, leave, by0, wide, tall) <= 0.0
            or in1 - out1 + _gain(entry, at1, leave, by1, wide, -tall) <= 0.0
            or in2 - out2 + _gain(entry, at2, leave, by2, -wide, tall) <= 0.0
            or in3 - out3 + _gain(entry, at3, leave, by3, -wide, -tall) <= 0.0
        ):
            result = MISSED
    return result


@njit(cache=True, error_model="numpy", inline="always")
def _gain(entry: Floats, at: int, leave: Floats, by: int, wide: float, tall: float) -> float:
    """Return the largest growth of the depth inside a solid from a corner to a ray of the same beam."""
    return max(0.0, wide * (entry[at, 1] - leave[by, 1])) + max(0.0, tall * (entry[at, 2] - leave[by, 2]))


@njit(cache=True, error_model="numpy", inline="always")
def plane_bounds(rows: Floats, p: int, cos: float, sin: float, low: float, high: float) -> tuple[float, float]:
    """Return the least and the largest inverse depth of plane p of `entry` or `leave` over the rays of a beam."""
    centre, turn = cos * rows[p, 0], abs(sin * rows[p, 1])
    down, up = low * rows[p, 2], high * rows[p, 2]
    return centre - turn + min(down, up), centre + turn + max(down, up)


@njit(cache=True, error_model="numpy", inline="always")
def keep_relevant(
    facing: int, hidden: int, entry: Floats, entry_plane: Ints, leave: Floats, cos: float, sin: float, low: float,
    high: float,
) -> tuple[int, int, float]:  # fmt: skip
    """Move the planes that decide entry or exit of any ray of a beam to the front; arguments as in `entry_of_corners`.

    Returns
    -------
    Number of planes kept in `entry` and in `leave`, and an upper bound of the inverse depth of the entry [1/m].
    """
    nearest, farthest = math.inf, -math.inf
    for p in range(facing):
        nearest = min(nearest, plane_bounds(entry, p, cos, sin, low, high)[1])
    for p in range(hidden):
        farthest = max(farthest, plane_bounds(leave, p, cos, sin, low, high)[0])
    entries, exits = 0, 0
    for p in range(facing):
        if plane_bounds(entry, p, cos, sin, low, high)[0] <= nearest:
            _swap(entry, p, entries)
            entry_plane[entries], entry_plane[p] = entry_plane[p], entry_plane[entries]
            entries += 1
    for p in range(hidden):
        if plane_bounds(leave, p, cos, sin, low, high)[1] >= farthest:
            _swap(leave, p, exits)
            exits += 1
    return entries, exits, nearest


@njit(cache=True, inline="always")
def _swap(rows: Floats, one: int, other: int) -> None:
    for axis in range(3):
        rows[one, axis], rows[other, axis] = rows[other, axis], rows[one, axis]


@njit(cache=True, error_model="numpy", inline="always")
def enter_through(
    at: int, entry: Floats, q: int, k: int, layer: int, side: Floats, slope: Floats, depth: Floats, plane: Ints
) -> None:
    """End the rays of the beam of a layer at azimuth k on plane q, row `at` of `entry`, where it is nearest."""
    per_cos, per_sin, per_slope = entry[at, 0], entry[at, 1], entry[at, 2]
    for r in range(side.shape[1]):
        enter = side[0, r] * per_cos + side[1, r] * per_sin + slope[k, layer, r] * per_slope
        plane[layer, r] = q if enter > depth[layer, r] else plane[layer, r]
        depth[layer, r] = max(enter, depth[layer, r])


@njit(cache=True, error_model="numpy", inline="always")
def enter_solid(
    facing: int, hidden: int, entry: Floats, entry_plane: Ints, leave: Floats, k: int, layer: int, side: Floats,
    slope: Floats, depth: Floats, plane: Ints,
) -> None:  # fmt: skip
    """End the rays of the beam of a layer at azimuth k on the solid of these planes where it is nearest."""
    for r in range(side.shape[1]):
        c, s, t = side[0, r], side[1, r], slope[k, layer, r]
        enter, through, leaves = math.inf, NONE, depth[layer, r]
        for p in range(facing):
            at = c * entry[p, 0] + s * entry[p, 1] + t * entry[p, 2]
            through, enter = p if at < enter else through, min(at, enter)
        for p in range(hidden):
            leaves = max(leaves, c * leave[p, 0] + s * leave[p, 1] + t * leave[p, 2])
        if leaves < enter:
            depth[layer, r], plane[layer, r] = enter, entry_plane[through]

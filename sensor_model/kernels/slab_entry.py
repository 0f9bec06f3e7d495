"""Entry of a column of rays into a convex solid n . p <= d, by the slab method.

A ray of slope s from o along f + s u hits a plane at the inverse depth (n . f + s n . u) / (d - n . o), linear in s.
It enters a solid at the least inverse depth of the planes that o is outside of. It hits the solid if that is more than
the inverse depth of each plane that o is inside of. No ray needs a division.

The functions are inlined, because a call costs an atomic reference count per array.
"""

import math

from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.records import NONE

_ON_PLANE = 1e-300  # distance inside of an origin on a plane: the ray leaves at once, and no division by zero occurs


@njit(cache=True, error_model="numpy", inline="always")
def start_column(m: int, column: Floats, slope: Floats, far: Floats, depth: Floats, plane: Ints) -> None:
    """Let the rays of column m end on the ground or at the maximum range.

    Parameters
    ----------
    column, slope, far
        As in `records.Rays`.
    depth
        (3, n) out: inverse depth per ray of its nearest hit; rows 1 and 2 are work space [1/m].
    plane
        (2, n) out: plane per ray of its nearest hit, or NONE; row 1 is work space.
    """
    level, per_slope = -column[5, m] / column[2, m], -column[8, m] / column[2, m]
    for i in range(slope.shape[1]):
        depth[0, i] = max(level + slope[m, i] * per_slope, far[m, i])
        plane[0, i] = NONE


@njit(cache=True, error_model="numpy", inline="always")
def split_planes(
    planes: Floats, begin: int, stop: int, local: Floats, c: int, entry: Floats, entry_plane: Ints, leave: Floats
) -> tuple[int, int]:
    """Split planes [begin, stop) into those that the origin of column c is outside of and those that it is inside of.

    Parameters
    ----------
    local
        (9, M) columns in the frame of the body: origin, forward, up.
    entry, leave
        (2, K) out: inverse depth at slope 0, and per slope, of the planes outside of which, and inside of which, it is.
    entry_plane
        (K,) out: planes of `entry`.

    Returns
    -------
    Number of each. Three dummy planes after each, without a hit, complete groups of four.
    """
    x, y, z = local[0, c], local[1, c], local[2, c]
    facing, hidden = 0, 0
    for q in range(begin, stop):
        nx, ny, nz = planes[q, 0], planes[q, 1], planes[q, 2]
        inward = planes[q, 3] - nx * x - ny * y - nz * z
        inward = inward if inward != 0.0 else _ON_PLANE
        per_metre = 1.0 / inward
        level = (nx * local[3, c] + ny * local[4, c] + nz * local[5, c]) * per_metre
        per_slope = (nx * local[6, c] + ny * local[7, c] + nz * local[8, c]) * per_metre
        entry[0, facing], entry[1, facing], entry_plane[facing] = level, per_slope, q
        leave[0, hidden], leave[1, hidden] = level, per_slope
        facing += inward < 0.0
        hidden += inward > 0.0
    for spare in range(3):
        entry[0, facing + spare], entry[1, facing + spare], entry_plane[facing + spare] = math.inf, 0.0, NONE
        leave[0, hidden + spare], leave[1, hidden + spare] = -math.inf, 0.0
    return facing, hidden


@njit(cache=True, error_model="numpy", inline="always")
def enter_solid(
    facing: int, hidden: int, entry: Floats, entry_plane: Ints, leave: Floats, slope: Floats, m: int, depth: Floats,
    plane_hit: Ints,
) -> float:  # fmt: skip
    """End the rays of column m on the solid of these planes where it is nearest.

    Four planes at a time stay in registers. Arguments as in `split_planes` and `start_column`.

    Returns
    -------
    Least inverse depth at which a ray of the column ends so far.
    """
    n = slope.shape[1]
    for i in range(n):
        depth[1, i], depth[2, i], plane_hit[1, i] = math.inf, depth[0, i], NONE
    for k in range(0, facing, 4):
        l0, l1, l2, l3 = entry[0, k], entry[0, k + 1], entry[0, k + 2], entry[0, k + 3]
        s0, s1, s2, s3 = entry[1, k], entry[1, k + 1], entry[1, k + 2], entry[1, k + 3]
        q0, q1, q2, q3 = entry_plane[k], entry_plane[k + 1], entry_plane[k + 2], entry_plane[k + 3]
        for i in range(n):
            s, enter, plane = slope[m, i], depth[1, i], plane_hit[1, i]
            at0, at1, at2, at3 = l0 + s * s0, l1 + s * s1, l2 + s * s2, l3 + s * s3
            plane, enter = q0 if at0 < enter else plane, min(at0, enter)
            plane, enter = q1 if at1 < enter else plane, min(at1, enter)
            plane, enter = q2 if at2 < enter else plane, min(at2, enter)
            plane, enter = q3 if at3 < enter else plane, min(at3, enter)
            depth[1, i], plane_hit[1, i] = enter, plane
    for k in range(0, hidden, 4):
        l0, l1, l2, l3 = leave[0, k], leave[0, k + 1], leave[0, k + 2], leave[0, k + 3]
        s0, s1, s2, s3 = leave[1, k], leave[1, k + 1], leave[1, k + 2], leave[1, k + 3]
        for i in range(n):
            s = slope[m, i]
            depth[2, i] = max(max(max(l0 + s * s0, l1 + s * s1), max(l2 + s * s2, l3 + s * s3)), depth[2, i])
    farthest = math.inf
    for i in range(n):
        enter, nearest = depth[1, i], depth[0, i]
        hit = depth[2, i] < enter < math.inf
        nearest = enter if hit else nearest
        depth[0, i], farthest = nearest, min(farthest, nearest)
        plane_hit[0, i] = plane_hit[1, i] if hit else plane_hit[0, i]
    return farthest

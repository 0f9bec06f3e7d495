"""Entry of the rays of one beam into a convex solid n . p <= d, by the slab method.

A ray c f + s l + t u from o hits a plane at the inverse depth n . (c f + s l + t u) / (d - n . o), linear in its
cosine c, sine s and slope t. It enters a solid at the least inverse depth of the planes that o is outside of. It hits
the solid if that is more than the inverse depth of each plane that o is inside of. No ray needs a division.

The functions are inlined, because a call costs an atomic reference count per array.
"""

import math

from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import NONE

_ON_PLANE = 1e-300  # distance inside of an origin on a plane: the ray leaves at once, and no division by zero occurs


@kernel(error_model="numpy", inline="always")
def start_rays(
    k: int, layer: int, line: Floats, side: Floats, slope: Floats, far: Floats, on_ground: Floats, depth: Floats,
    plane: Ints,
) -> None:  # fmt: skip
    """Let the rays of the beam of a layer at azimuth k end on the ground or at the maximum range.

    Parameters
    ----------
    line, side, slope, far, on_ground
        As in `records.Rays`.
    depth
        (L, R) out: inverse depth per ray of its nearest hit [1/m].
    plane
        (L, R) out: plane per ray of its nearest hit, or NONE.
    """
    flat = len(on_ground) == 0
    per_cos, per_sin, per_slope = -line[5, k] / line[2, k], -line[8, k] / line[2, k], -line[11, k] / line[2, k]
    for r in range(side.shape[1]):
        at = side[0, r] * per_cos + side[1, r] * per_sin + slope[k, layer, r] * per_slope
        depth[layer, r] = max(at, far[k, layer, r]) if flat else on_ground[k, layer, r]
        plane[layer, r] = NONE


@kernel(error_model="numpy", inline="always")
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


@kernel(error_model="numpy", inline="always")
def enter_through(
    at: int, entry: Floats, q: int, k: int, layer: int, side: Floats, slope: Floats, depth: Floats, plane: Ints
) -> None:
    """End the rays of the beam of a layer at azimuth k on plane q, row `at` of `entry`, where it is nearest."""
    per_cos, per_sin, per_slope = entry[at, 0], entry[at, 1], entry[at, 2]
    for r in range(side.shape[1]):
        enter = side[0, r] * per_cos + side[1, r] * per_sin + slope[k, layer, r] * per_slope
        plane[layer, r] = q if enter > depth[layer, r] else plane[layer, r]
        depth[layer, r] = max(enter, depth[layer, r])


@kernel(error_model="numpy", inline="always")
def enter_solid(
    facing: int, hidden: int, entry: Floats, entry_plane: Ints, leave: Floats, k: int, layer: int, side: Floats,
    slope: Floats, depth: Floats, plane: Ints, enter: Floats, through: Ints,
) -> None:  # fmt: skip
    """End the rays of the beam of a layer at azimuth k on the solid of these planes where it is nearest.

    `enter` (2, R) and `through` (R,) are work space.
    """
    for r in range(side.shape[1]):
        enter[0, r], enter[1, r], through[r] = math.inf, depth[layer, r], NONE
    for p in range(facing):
        per_cos, per_sin, per_slope, q = entry[p, 0], entry[p, 1], entry[p, 2], entry_plane[p]
        for r in range(side.shape[1]):
            at = side[0, r] * per_cos + side[1, r] * per_sin + slope[k, layer, r] * per_slope
            through[r] = q if at < enter[0, r] else through[r]
            enter[0, r] = min(at, enter[0, r])
    for p in range(hidden):
        per_cos, per_sin, per_slope = leave[p, 0], leave[p, 1], leave[p, 2]
        for r in range(side.shape[1]):
            at = side[0, r] * per_cos + side[1, r] * per_sin + slope[k, layer, r] * per_slope
            enter[1, r] = max(enter[1, r], at)
    for r in range(side.shape[1]):
        hits = enter[1, r] < enter[0, r] < math.inf
        depth[layer, r] = enter[0, r] if hits else depth[layer, r]
        plane[layer, r] = through[r] if hits else plane[layer, r]


@kernel(error_model="numpy", inline="always")
def enter_by_ray(
    facing: int, hidden: int, entry: Floats, entry_plane: Ints, leave: Floats, k: int, layer: int, slope: Floats,
    depth: Floats, plane: Ints,
) -> None:  # fmt: skip
    """End the ray of a beam of one ray on the solid where it is nearest, in registers; its azimuth is the beam's."""
    enter, through, leaves, t = math.inf, 0, depth[layer, 0], slope[k, layer, 0]
    for p in range(facing):
        at = entry[p, 0] + t * entry[p, 2]
        through, enter = p if at < enter else through, min(at, enter)
    for p in range(hidden):
        leaves = max(leaves, leave[p, 0] + t * leave[p, 2])
    if leaves < enter < math.inf:
        depth[layer, 0], plane[layer, 0] = enter, entry_plane[through]

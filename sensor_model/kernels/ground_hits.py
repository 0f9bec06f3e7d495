"""Intersections of rays with uneven ground: a grid of nodes, two triangles per cell.

A ray passes the cells under it one by one (Amanatides and Woo 1987, "A Fast Voxel Traversal Algorithm for Ray
Tracing"), first square blocks of cells, and the cells of a block only if it comes below the block's lid, a plane on or
above all its nodes. In a triangle the height of a ray above the ground is linear, so that its zero is exact.
"""

import math

from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import (
    COSINE,
    INNER_SURFACE,
    INVERSE_DEPTH,
    NONE,
    TARGET,
    Ground,
    Rays,
)
from luxloop.sensor_model.returns import GROUND, NOTHING

BLOCK = 8
"""Cells along the side of a block."""

Vector = tuple[float, float, float]


@kernel(error_model="numpy")
def intersect_terrain(rays: Rays, ground: Ground) -> None:
    """End the rays on uneven ground, or on nothing at the maximum range."""
    line, side, slope, cos, far = rays.line, rays.side, rays.slope, rays.cos, rays.far
    inverse_depth, cosine = rays.hit[INVERSE_DEPTH], rays.hit[COSINE]
    target, inner_surface, on_ground = rays.hit_id[TARGET], rays.hit_id[INNER_SURFACE], rays.on_ground
    height, lid, pose = ground.height, ground.lid, ground.pose
    for k in range(len(slope)):
        start = line[0, k], line[1, k], line[2, k]
        for layer in range(slope.shape[1]):
            for r in range(slope.shape[2]):
                c, s, t = side[0, r], side[1, r], slope[k, layer, r]
                along = (
                    c * line[3, k] + s * line[6, k] + t * line[9, k],
                    c * line[4, k] + s * line[7, k] + t * line[10, k],
                    c * line[5, k] + s * line[8, k] + t * line[11, k],
                )
                limit = 1.0 / far[k, layer, r]
                at, facing = _terrain_hit(start, along, limit, height, lid, pose)
                hits = at < limit
                inverse_depth[k, layer, r] = on_ground[k, layer, r] = 1.0 / at if hits else far[k, layer, r]
                target[k, layer, r] = GROUND if hits else NOTHING
                cosine[k, layer, r] = facing * cos[k, layer, r]
                inner_surface[k, layer, r] = NONE


@kernel(error_model="numpy")
def terrain_hit(start: Vector, along: Vector, limit: float, ground: Ground) -> tuple[float, float]:
    """Return where a ray meets the ground from above, in lengths of `along`, infinite if not before `limit`.

    The second value is the cosine of incidence times the length of `along`.
    """
    return _terrain_hit(start, along, limit, ground.height, ground.lid, ground.pose)


@kernel(error_model="numpy")
def _terrain_hit(
    start: Vector, along: Vector, limit: float, height: Floats, lid: Floats, pose: Floats
) -> tuple[float, float]:
    """Return as `terrain_hit`; the arrays are those of `records.Ground`."""
    cos, sin, cell = pose[2], pose[3], pose[5]
    x, y = pose[0] + cos * start[0] - sin * start[1], pose[1] + sin * start[0] + cos * start[1]
    dx, dy = cos * along[0] - sin * along[1], sin * along[0] + cos * along[1]
    z, dz, peak = start[2] + pose[4], along[2], pose[6]
    i, j = math.floor(x), math.floor(y)
    if z <= _height(height, i, j, x - i, y - j):
        return math.inf, 0.0
    i, j, begin = math.floor(x / BLOCK), math.floor(y / BLOCK), 0.0
    while begin < limit:
        if dz >= 0.0 and z + begin * dz > peak:
            break
        end_x, end_y = _border(x, dx, i, BLOCK), _border(y, dy, j, BLOCK)
        end = max(begin, min(end_x, end_y, limit))
        p, q = _within(i, lid.shape[0]), _within(j, lid.shape[1])
        tilt_x, tilt_y = lid[p, q, 0], lid[p, q, 1]
        above, rate = z - tilt_x * x - tilt_y * y - lid[p, q, 2], dz - tilt_x * dx - tilt_y * dy
        if above + begin * rate <= 0.0 or above + end * rate <= 0.0:
            at, tilt_x, tilt_y = _in_block(height, x, y, z, dx, dy, dz, begin, end)
            if at < limit:
                steep = 1.0 + (tilt_x * tilt_x + tilt_y * tilt_y) / (cell * cell)
                return at, (tilt_x * dx + tilt_y * dy - dz) / math.sqrt(steep)
        begin = end
        if end_x <= end_y:
            i += 1 if dx > 0.0 else -1
        else:
            j += 1 if dy > 0.0 else -1
    return math.inf, 0.0


@kernel(error_model="numpy")
def _in_block(
    height: Floats, x: float, y: float, z: float, dx: float, dy: float, dz: float, begin: float, stop: float
) -> tuple[float, float, float]:
    """Return where a ray between two lengths first is on the ground, infinite if not, and the ground's rise per cell.

    It is above the ground at the first length, but for rounding.
    """
    i, j = math.floor(x + begin * dx), math.floor(y + begin * dy)
    while begin < stop:
        end_x, end_y = _border(x, dx, i, 1), _border(y, dy, j, 1)
        end = max(begin, min(end_x, end_y, stop))
        # across the diagonal of the cell, at the length `middle`, the plane changes
        across = (x - i) - (y - j)
        middle = min(end, max(begin, -across / (dx - dy) if dx != dy else begin))
        for first, last in ((begin, middle), (middle, end)):
            right = across + 0.5 * (first + last) * (dx - dy) >= 0.0
            low, tilt_x, tilt_y = _plane(height, i, j, right)
            above = z - low - tilt_x * (x - i) - tilt_y * (y - j)
            rate = dz - tilt_x * dx - tilt_y * dy
            if above + last * rate <= 0.0:
                return max(first, min(last, -above / rate if rate < 0.0 else first)), tilt_x, tilt_y
        begin = end
        if end_x <= end_y:
            i += 1 if dx > 0.0 else -1
        else:
            j += 1 if dy > 0.0 else -1
    return math.inf, 0.0, 0.0


@kernel(error_model="numpy", inline="always")
def _border(place: float, rate: float, cell: int, size: int) -> float:
    """Return the length at which a ray leaves cell number `cell` of a size, along one axis."""
    return ((cell + (1 if rate > 0.0 else 0)) * size - place) / rate if rate != 0.0 else math.inf


@kernel(inline="always")
def _within(index: int, count: int) -> int:
    """Return the nearest index of an array."""
    return min(max(index, 0), count - 1)


@kernel(inline="always")
def _plane(height: Floats, i: int, j: int, right: bool) -> tuple[float, float, float]:
    """Return the height at the first node of a cell, and the rise per cell in x and y of one of its triangles."""
    low_i, high_i = _within(i, height.shape[0]), _within(i + 1, height.shape[0])
    low_j, high_j = _within(j, height.shape[1]), _within(j + 1, height.shape[1])
    low, high = height[low_i, low_j], height[high_i, high_j]
    other = height[high_i, low_j] if right else height[low_i, high_j]
    return (low, other - low, high - other) if right else (low, high - other, other - low)


@kernel(inline="always")
def _height(height: Floats, i: int, j: int, u: float, v: float) -> float:
    """Return the height in a cell (i, j) at the shares (u, v) of its sides."""
    low, tilt_x, tilt_y = _plane(height, i, j, u >= v)
    return low + u * tilt_x + v * tilt_y

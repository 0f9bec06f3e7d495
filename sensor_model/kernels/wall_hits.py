"""Intersections of the rays of a block of azimuths with walls.

On the plane of a wall, the inverse depth of a ray is linear in its cosine, sine and slope. So are the position along
the wall and the height, both times the inverse depth. A ray hits the wall where four such forms are not negative. Their
bounds over a beam decide most beams.
"""

import math

from luxloop.arrays import Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.corner_rays import depth_bounds
from luxloop.sensor_model.kernels.records import COSINE, INVERSE_DEPTH, SURFACE, TARGET, Rays, StaticScene
from luxloop.sensor_model.returns import WALL


@kernel(error_model="numpy")
def intersect_walls(rows: Ints, refine: bool, rays: Rays, static: StaticScene) -> None:
    """End the rays on walls nearer than their hits so far.

    Parameters
    ----------
    rows
        (N, 3) wall, first azimuth, and end.
    refine
        As in `records.Grid`.
    """
    for row in range(len(rows)):
        _intersect_wall(rows[row, 0], rows[row, 1], rows[row, 2], refine, rays, static)


@kernel(error_model="numpy")
def _intersect_wall(w: int, first: int, end: int, refine: bool, rays: Rays, static: StaticScene) -> None:
    """End the rays of azimuths [first, end) on wall w where it is nearer than their hits so far."""
    # Unpacked once: each access to a record's array costs an atomic reference count.
    ends, z, line, side, slope, cos = static.ends, static.z, rays.line, rays.side, rays.slope, rays.cos
    inverse_depth, cosine = rays.hit[INVERSE_DEPTH], rays.hit[COSINE]
    target, surface = rays.hit_id[TARGET], rays.hit_id[SURFACE]
    edge_cos, edge_sin = side[0, 0], abs(side[1, 0])
    ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
    length = math.sqrt(ex * ex + ey * ey)
    ex, ey = ex / length, ey / length
    for k in range(first, end):
        gx, gy = ends[w, 0] - line[0, k], ends[w, 1] - line[1, k]
        aside, before = gx * ey - gy * ex, gx * ex + gy * ey
        if aside == 0.0:  # seen edge on
            continue
        # Per cosine, sine and slope: inverse depth, and position along the wall and height times inverse depth.
        d0 = (line[3, k] * ey - line[4, k] * ex) / aside
        d1 = (line[6, k] * ey - line[7, k] * ex) / aside
        d2 = (line[9, k] * ey - line[10, k] * ex) / aside
        a0 = line[3, k] * ex + line[4, k] * ey - before * d0
        a1 = line[6, k] * ex + line[7, k] * ey - before * d1
        a2 = line[9, k] * ex + line[10, k] * ey - before * d2
        h0, h1, h2 = line[5, k] + line[2, k] * d0, line[8, k] + line[2, k] * d1, line[11, k] + line[2, k] * d2
        for layer in range(slope.shape[1]):
            low, high = slope[k, layer, 0], slope[k, layer, -1]
            least, most = depth_bounds(d0, d1, d2, edge_cos, edge_sin, low, high)
            begins, behind = depth_bounds(a0, a1, a2, edge_cos, edge_sin, low, high)
            left, ahead = depth_bounds(
                length * d0 - a0, length * d1 - a1, length * d2 - a2, edge_cos, edge_sin, low, high
            )
            bottom, above = depth_bounds(
                h0 - z[w, 0] * d0, h1 - z[w, 0] * d1, h2 - z[w, 0] * d2, edge_cos, edge_sin, low, high
            )
            top, below = depth_bounds(
                z[w, 1] * d0 - h0, z[w, 1] * d1 - h1, z[w, 1] * d2 - h2, edge_cos, edge_sin, low, high
            )
            if refine and (most <= 0.0 or behind < 0.0 or ahead < 0.0 or above < 0.0 or below < 0.0):
                continue
            whole = refine and least > 0.0 and begins >= 0.0 and left >= 0.0 and bottom >= 0.0 and top >= 0.0
            for r in range(slope.shape[2]):
                c, s, t = side[0, r], side[1, r], slope[k, layer, r]
                at = c * d0 + s * d1 + t * d2
                if not at > inverse_depth[k, layer, r]:
                    continue
                if not whole:
                    along, height = c * a0 + s * a1 + t * a2, c * h0 + s * h1 + t * h2
                    if not (0.0 <= along <= length * at and z[w, 0] * at <= height <= z[w, 1] * at):
                        continue
                inverse_depth[k, layer, r], target[k, layer, r], surface[k, layer, r] = at, WALL, w
                cosine[k, layer, r] = abs(aside) * at * cos[k, layer, r]

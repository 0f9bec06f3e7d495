"""Intersections of the rays of a fan with bodies: nearest hits, and hits behind panes."""

import numpy as np
from numba import njit

from sensor_model.arrays import Bools, Floats, Ints
from sensor_model.kernels.body_frame import column_limits, column_span, into_body_frame, plan_distance, slope_extremes
from sensor_model.kernels.records import (
    COSINE,
    INNER_COSINE,
    INNER_INVERSE_DEPTH,
    INNER_SURFACE,
    INVERSE_DEPTH,
    NONE,
    SURFACE,
    TARGET,
    Rays,
    Solids,
)
from sensor_model.kernels.slab_entry import enter_solid, split_planes, start_column

_SLACK = 1e-9  # tolerance for rounding, so that no hit is left out


@njit(cache=True, error_model="numpy")
def intersect_bodies(rows: Ints, rays_wide: int, time: Floats, rays: Rays, bodies: Solids, hits_alone: Ints) -> None:
    """End the rays on bodies nearer than their hits so far, and continue behind panes.

    Parameters
    ----------
    rows
        (K, 3) body, first azimuth, and end.
    time
        (M / J,) firing times of the fan's azimuths [s].
    hits_alone
        (A,) in and out: rays that would end on each body if it were alone on the ground.
    """
    # Unpacked once: each access to a record's array costs an atomic reference count.
    column, slope, cos, far, hit, hit_id = rays
    body_solid, solid_plane, solid_bounds = bodies.body_solid, bodies.solid_plane, bodies.solid_bounds
    motion, solid_inner, planes, transmission = bodies.motion, bodies.solid_inner, bodies.planes, bodies.transmission
    columns, n = slope.shape
    local, limits, extremes = np.empty((9, columns)), np.empty((6, columns)), slope_extremes(slope)
    longest = np.sqrt(1.0 + np.maximum(extremes[0] ** 2, extremes[1] ** 2)) + _SLACK
    span, room = np.empty((2, len(solid_inner)), np.int64), _largest_group(solid_plane) + 3
    entry, leave, entry_plane = np.empty((2, room)), np.empty((2, room)), np.empty(room, np.int64)
    depth, plane, on_pane = np.empty((3, n)), np.empty((2, n), np.int64), np.empty(n, np.bool_)
    for row in range(len(rows)):
        a, first, end = rows[row, 0], rows[row, 1] * rays_wide, rows[row, 2] * rays_wide
        into_body_frame(column, rows[row, 1], rows[row, 2], rays_wide, time, motion, a, local)
        column_limits(local, extremes, first, end - first, limits)
        for p in range(body_solid[a], body_solid[a + 1]):
            span[0, p], span[1, p] = column_span(solid_bounds, p, local, end - first, limits)
        for c in range(end - first):
            m = first + c
            for inner in range(2):  # outer solids, then those behind a pane
                start_column(m, column, slope, far, depth, plane)
                entered, farthest = False, 0.0
                for p in range(body_solid[a], body_solid[a + 1]):
                    if span[0, p] <= c < span[1, p] and solid_inner[p] == inner:
                        if farthest * plan_distance(solid_bounds, p, local, c) > longest[m]:
                            continue
                        facing, hidden = split_planes(
                            planes, solid_plane[p], solid_plane[p + 1], local, c, entry, entry_plane, leave
                        )
                        if facing > 0:
                            farthest = enter_solid(facing, hidden, entry, entry_plane, leave, slope, m, depth, plane)
                            entered = True
                if not entered:
                    break
                if inner:
                    _look_inside(on_pane, planes, local, c, m, depth, plane, cos, hit, hit_id)
                    break
                alone, nearer = _keep_nearer(a, planes, local, c, m, depth, plane, cos, hit, hit_id)
                hits_alone[a] += alone
                if nearer == 0 or not _find_panes(a, m, transmission, hit_id, on_pane):
                    break


@njit(cache=True)
def _largest_group(offsets: Ints) -> int:
    """Return the size of the largest group; group g has members offsets[g] to offsets[g + 1]."""
    most = 0
    for g in range(len(offsets) - 1):
        most = max(most, offsets[g + 1] - offsets[g])
    return most


@njit(cache=True, error_model="numpy", inline="always")
def _height(planes: Floats, q: int, local: Floats, c: int) -> float:
    """Return the distance of the origin of column c outside of plane q; over the range, the cosine of incidence."""
    return float(planes[q, 0] * local[0, c] + planes[q, 1] * local[1, c] + planes[q, 2] * local[2, c] - planes[q, 3])


@njit(cache=True, error_model="numpy", inline="always")
def _keep_nearer(
    a: int, planes: Floats, local: Floats, c: int, m: int, depth: Floats, plane: Ints, cos: Floats, hit: Floats,
    hit_id: Ints,
) -> tuple[int, int]:  # fmt: skip
    """End the rays of column m on body a where it is nearer than their hits so far.

    Returns
    -------
    Number of rays that hit the body if it is alone, and of those that end on it now.
    """
    alone, nearer = 0, 0
    for i in range(cos.shape[1]):
        q, at = plane[0, i], depth[0, i]
        if q != NONE:
            alone += 1
            if at > hit[INVERSE_DEPTH, m, i]:
                nearer += 1
                hit_id[TARGET, m, i], hit_id[SURFACE, m, i], hit_id[INNER_SURFACE, m, i] = a, q, NONE
                hit[INVERSE_DEPTH, m, i] = at
                hit[COSINE, m, i] = _height(planes, q, local, c) * at * cos[m, i]
    return alone, nearer


@njit(cache=True, inline="always")
def _find_panes(a: int, m: int, transmission: Floats, hit_id: Ints, on_pane: Bools) -> bool:
    """Fill the (n,) mask of the rays of column m that end on a pane of body a; return True if any does."""
    panes = False
    for i in range(len(on_pane)):
        on_pane[i] = hit_id[TARGET, m, i] == a and transmission[hit_id[SURFACE, m, i]] > 0.0
        panes = panes or on_pane[i]
    return panes


@njit(cache=True, error_model="numpy", inline="always")
def _look_inside(
    on_pane: Bools, planes: Floats, local: Floats, c: int, m: int, depth: Floats, plane: Ints, cos: Floats, hit: Floats,
    hit_id: Ints,
) -> None:  # fmt: skip
    """Continue the rays of column m that end on a pane to the inner solid behind it."""
    for i in range(cos.shape[1]):
        q, at = plane[0, i], depth[0, i]
        if q != NONE and on_pane[i]:
            hit_id[INNER_SURFACE, m, i], hit[INNER_INVERSE_DEPTH, m, i] = q, at
            hit[INNER_COSINE, m, i] = _height(planes, q, local, c) * at * cos[m, i]

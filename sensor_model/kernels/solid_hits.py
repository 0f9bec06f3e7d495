"""Intersections of the rays of a block of azimuths with bodies: nearest hits, and hits behind panes."""

import numpy as np
from numba import njit

from sensor_model.arrays import Bools, Floats, Ints
from sensor_model.kernels.body_frame import azimuth_limits, azimuth_span, into_body_frame, plan_distance, slope_extremes
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
from sensor_model.kernels.slab_entry import (
    CROSSED,
    MISSED,
    enter_solid,
    enter_through,
    entry_of_corners,
    keep_relevant,
    plane_bounds,
    split_planes,
    start_rays,
)

UNTOUCHED = -1.0
_SLACK = 1e-9  # tolerance for rounding, so that no hit is left out


@njit(cache=True, error_model="numpy")
def intersect_bodies(
    rows: Ints, half_width: float, refine: bool, time: Floats, rays: Rays, bodies: Solids, hits_alone: Ints
) -> None:
    """End the rays on bodies nearer than their hits so far, and continue behind panes.

    Parameters
    ----------
    rows
        (N, 3) body, first azimuth, and end.
    half_width
        Half of a beam's width [rad].
    refine
        As in `records.Grid`.
    time
        (K,) firing times of the azimuths [s].
    hits_alone
        (A,) in and out: rays that would end on each body if it were alone on the ground.
    """
    # Unpacked once: each access to a record's array costs an atomic reference count.
    line, side, slope, cos, far, hit, hit_id = rays
    body_solid, solid_plane, solid_bounds = bodies.body_solid, bodies.solid_plane, bodies.solid_bounds
    motion, solid_inner, planes, transmission = bodies.motion, bodies.solid_inner, bodies.planes, bodies.transmission
    azimuths, layers, per_beam = slope.shape
    edge_cos, edge_sin = side[0, 0], abs(side[1, 0])
    local, limits, extremes = np.empty((12, azimuths)), np.empty((7, azimuths)), slope_extremes(slope)
    longest = np.sqrt(1.0 + np.maximum(extremes[0] ** 2, extremes[1] ** 2)) + _SLACK
    span, room = np.empty((2, len(solid_inner)), np.int64), _largest_group(solid_plane)
    solid, in_view = np.empty((2, _largest_group(body_solid) + 1), np.int64), np.empty(2, np.int64)
    entry, leave, entry_plane = np.empty((room, 3)), np.empty((room, 3)), np.empty(room, np.int64)
    beams = (layers, per_beam)
    depth, plane, on_pane = np.empty(beams), np.empty(beams, np.int64), np.zeros(beams, np.bool_)
    farthest, covered = np.empty(layers), np.zeros((azimuths, layers))
    for row in range(len(rows)):
        a, first, end = rows[row, 0], rows[row, 1], rows[row, 2]
        into_body_frame(line, first, end, time, motion, a, local)
        azimuth_limits(local, extremes, first, end - first, half_width, limits)
        in_view[0] = in_view[1] = 0
        for p in range(body_solid[a], body_solid[a + 1]):
            span[0, p], span[1, p] = azimuth_span(solid_bounds, p, local, end - first, limits)
            inner = int(solid_inner[p])
            solid[inner, in_view[inner]] = p
            in_view[inner] += span[0, p] < span[1, p]
        for c in range(end - first):
            k = first + c
            nearest = longest[k] / plan_distance(bodies.bounds, a, local, c)
            for inner in range(2):  # outer solids, then those behind a pane
                farthest[:] = UNTOUCHED
                for j in range(in_view[inner]):
                    p = solid[inner, j]
                    if not span[0, p] <= c < span[1, p]:
                        continue
                    if farthest.min() * plan_distance(solid_bounds, p, local, c) > longest[k]:
                        continue
                    facing, hidden = split_planes(
                        planes, solid_plane[p], solid_plane[p + 1], local, c, entry, entry_plane, leave
                    )
                    for layer in range(layers if facing > 0 else 0):
                        bottom, top = slope[k, layer, 0], slope[k, layer, -1]
                        at = CROSSED
                        if refine:
                            at = entry_of_corners(facing, hidden, entry, leave, edge_cos, edge_sin, bottom, top)
                            if at == MISSED:
                                continue
                            if at >= 0 and nearest < covered[k, layer]:
                                farthest[layer] = np.inf
                                continue
                        if farthest[layer] == UNTOUCHED:
                            start_rays(k, layer, line, side, slope, far, depth, plane)
                            farthest[layer] = 0.0
                        if at >= 0:
                            enter_through(at, entry, entry_plane[at], k, layer, side, slope, depth, plane)
                            least, _ = plane_bounds(entry, at, edge_cos, edge_sin, bottom, top)
                            farthest[layer] = max(farthest[layer], least)
                            continue
                        entries, exits = facing, hidden
                        if refine:
                            entries, exits, most = keep_relevant(
                                facing, hidden, entry, entry_plane, leave, edge_cos, edge_sin, bottom, top
                            )
                            if most <= farthest[layer]:
                                continue
                        enter_solid(entries, exits, entry, entry_plane, leave, k, layer, side, slope, depth, plane)
                panes = False
                for layer in range(layers):
                    if farthest[layer] == np.inf:
                        hits_alone[a] += per_beam
                    elif inner and farthest[layer] != UNTOUCHED:
                        _look_inside(on_pane, planes, local, c, k, layer, depth, plane, cos, hit, hit_id)
                    elif not inner:
                        on_pane[layer] = False
                        if farthest[layer] == UNTOUCHED:
                            continue
                        alone, nearer = _keep_nearer(
                            a, planes, local, c, k, layer, depth, plane, cos, hit, hit_id
                        )
                        hits_alone[a] += alone
                        covered[k, layer] = max(covered[k, layer], farthest[layer])
                        if nearer > 0:
                            panes = _find_panes(a, k, layer, transmission, hit_id, on_pane) or panes
                if inner or not panes:
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
    """Return the distance of the origin of azimuth c outside of plane q; over the range, the cosine of incidence."""
    return float(planes[q, 0] * local[0, c] + planes[q, 1] * local[1, c] + planes[q, 2] * local[2, c] - planes[q, 3])


@njit(cache=True, error_model="numpy", inline="always")
def _keep_nearer(
    a: int, planes: Floats, local: Floats, c: int, k: int, layer: int, depth: Floats, plane: Ints, cos: Floats,
    hit: Floats, hit_id: Ints,
) -> tuple[int, int]:  # fmt: skip
    """End the rays of azimuth k on body a where it is nearer than their hits so far.

    Returns
    -------
    Number of rays that hit the body if it is alone, and of those that end on it now.
    """
    alone, nearer = 0, 0
    for r in range(cos.shape[2]):
        q, at = plane[layer, r], depth[layer, r]
        if q != NONE:
            alone += 1
            if at > hit[INVERSE_DEPTH, k, layer, r]:
                nearer += 1
                hit_id[TARGET, k, layer, r], hit_id[SURFACE, k, layer, r], hit_id[INNER_SURFACE, k, layer, r] = a, q, NONE
                hit[INVERSE_DEPTH, k, layer, r] = at
                hit[COSINE, k, layer, r] = _height(planes, q, local, c) * at * cos[k, layer, r]
    return alone, nearer


@njit(cache=True, inline="always")
def _find_panes(
    a: int, k: int, layer: int, transmission: Floats, hit_id: Ints, on_pane: Bools
) -> bool:
    """Fill the (n,) mask of the rays of azimuth k that end on a pane of body a; return True if any does."""
    panes = False
    for r in range(on_pane.shape[1]):
        on_pane[layer, r] = hit_id[TARGET, k, layer, r] == a and transmission[hit_id[SURFACE, k, layer, r]] > 0.0
        panes = panes or on_pane[layer, r]
    return panes


@njit(cache=True, error_model="numpy", inline="always")
def _look_inside(
    on_pane: Bools, planes: Floats, local: Floats, c: int, k: int, layer: int, depth: Floats, plane: Ints,
    cos: Floats, hit: Floats, hit_id: Ints,
) -> None:  # fmt: skip
    """Continue the rays of azimuth k that end on a pane to the inner solid behind it."""
    for r in range(cos.shape[2]):
        q, at = plane[layer, r], depth[layer, r]
        if q != NONE and on_pane[layer, r]:
            hit_id[INNER_SURFACE, k, layer, r], hit[INNER_INVERSE_DEPTH, k, layer, r] = q, at
            hit[INNER_COSINE, k, layer, r] = _height(planes, q, local, c) * at * cos[k, layer, r]

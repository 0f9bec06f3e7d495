"""Intersections of the rays of a block of azimuths with bodies: nearest hits, and hits behind panes.

Functions over the rays of one beam are inlined, because a call costs an atomic reference count per array.
"""

import math

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.body_frame import (
    azimuth_limits,
    azimuth_span,
    farthest_distance,
    into_body_frame,
    plan_distance,
    slope_extremes,
)
from luxloop.sensor_model.kernels.corner_rays import MISSED, depth_bounds, entry_of_corners, keep_relevant
from luxloop.sensor_model.kernels.records import (
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
from luxloop.sensor_model.kernels.slab_entry import enter_by_ray, enter_solid, enter_through, split_planes, start_rays

PASSED = -1.0
"""In place of the inverse depth of a beam: no solid enters it."""
HIDDEN = math.inf
"""In place of the inverse depth of a beam: a body behind nearer ones covers it, so that only its rays are counted."""


@kernel(error_model="numpy", inline="always")
def keep_nearer(
    a: int, farthest: float, planes: Floats, local: Floats, c: int, k: int, layer: int, depth: Floats, plane: Ints,
    cos: Floats, hit: Floats, hit_id: Ints,
) -> tuple[int, int]:  # fmt: skip
    """End the rays of a beam on body a where it is nearer than their hits so far; `farthest` as in `solid_hits`.

    Returns
    -------
    Number of rays that hit the body if it is alone, and of those that end on it now.
    """
    x, y, z = local[0, c], local[1, c], local[2, c]
    # The distance of the origin outside of a plane, over the range, is the cosine of incidence.
    alone, nearer = cos.shape[2] if farthest == HIDDEN else 0, 0
    for r in range(cos.shape[2] if 0.0 <= farthest < HIDDEN else 0):
        q, at = plane[layer, r], depth[layer, r]
        if q != NONE:
            alone += 1
            if at > hit[INVERSE_DEPTH, k, layer, r]:
                nearer += 1
                hit_id[TARGET, k, layer, r], hit_id[SURFACE, k, layer, r] = a, q
                hit_id[INNER_SURFACE, k, layer, r] = NONE
                hit[INVERSE_DEPTH, k, layer, r] = at
                height = planes[q, 0] * x + planes[q, 1] * y + planes[q, 2] * z - planes[q, 3]
                hit[COSINE, k, layer, r] = height * at * cos[k, layer, r]
    return alone, nearer


@kernel(inline="always")
def find_panes(a: int, nearer: int, k: int, layer: int, transmission: Floats, hit_id: Ints, on_pane: Bools) -> bool:
    """Set the (R,) mask of the rays of a beam that end on a pane of body a; return True if any does.

    Parameters
    ----------
    nearer
        Number of rays of the beam that end on body a now.
    """
    panes = False
    for r in range(on_pane.shape[1]):
        on_pane[layer, r] = (
            nearer > 0 and hit_id[TARGET, k, layer, r] == a and transmission[hit_id[SURFACE, k, layer, r]] > 0.0
        )
        panes = panes or on_pane[layer, r]
    return panes


@kernel(error_model="numpy", inline="always")
def look_inside(
    farthest: float, on_pane: Bools, planes: Floats, local: Floats, c: int, k: int, layer: int, depth: Floats,
    plane: Ints, cos: Floats, hit: Floats, hit_id: Ints,
) -> None:  # fmt: skip
    """Continue the rays of a beam that end on a pane to the inner solid behind it; `farthest` as in `solid_hits`."""
    x, y, z = local[0, c], local[1, c], local[2, c]
    for r in range(cos.shape[2] if 0.0 <= farthest < HIDDEN else 0):
        q, at = plane[layer, r], depth[layer, r]
        if q != NONE and on_pane[layer, r]:
            hit_id[INNER_SURFACE, k, layer, r], hit[INNER_INVERSE_DEPTH, k, layer, r] = q, at
            height = planes[q, 0] * x + planes[q, 1] * y + planes[q, 2] * z - planes[q, 3]
            hit[INNER_COSINE, k, layer, r] = height * at * cos[k, layer, r]


@kernel(error_model="numpy")
def intersect_bodies(
    rows: Ints, half_width: float, refine: bool, time: Floats, rays: Rays, bodies: Solids, hits_alone: Ints
) -> None:
    """End the rays on bodies nearer than their hits so far, and continue behind panes.

    Parameters
    ----------
    rows
        (N, 3) body, first azimuth, and end; near bodies first, because hidden ones cost less.
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
    line, slope = rays.line, rays.slope
    body_solid, solid_plane, solid_bounds = bodies.body_solid, bodies.solid_plane, bodies.solid_bounds
    motion, solid_inner, (azimuths, layers, per_beam) = bodies.motion, bodies.solid_inner, slope.shape
    local, limits, (extremes, longest) = np.empty((12, azimuths)), np.empty((7, azimuths)), slope_extremes(slope)
    in_view, views = np.empty((2, _largest_group(body_solid) + 1), np.int64), np.empty(2, np.int64)
    span, room = np.empty((2, len(solid_inner)), np.int64), _largest_group(solid_plane)
    entry, leave, entry_plane = np.empty((room, 3)), np.empty((room, 3)), np.empty(room, np.int64)
    enter, through = np.empty((2, per_beam)), np.empty(per_beam, np.int64)
    depth, plane = np.empty((layers, per_beam)), np.empty((layers, per_beam), np.int64)
    on_pane, farthest, covered = np.empty((layers, per_beam), np.bool_), np.empty(layers), np.zeros((azimuths, layers))
    for row in range(len(rows)):
        a, first, end = rows[row, 0], rows[row, 1], rows[row, 2]
        into_body_frame(line, first, end, time, motion, a, local)
        azimuth_limits(local, extremes, first, end - first, half_width, limits)
        _list_solids(a, body_solid, solid_inner, solid_bounds, local, end - first, limits, span, in_view, views)
        hits_alone[a] += _cast_body(
            a, first, end, refine, rays, bodies, local, longest, span, in_view, views, entry, leave, entry_plane,
            depth, plane, enter, through, on_pane, farthest, covered,
        )  # fmt: skip


@kernel(inline="always")
def _list_solids(
    a: int, body_solid: Ints, solid_inner: Bools, solid_bounds: Floats, local: Floats, azimuths: int, limits: Floats,
    span: Ints, in_view: Ints, views: Ints,
) -> None:  # fmt: skip
    """List the outer and the inner solids of body a that rays of the azimuths may hit.

    Parameters
    ----------
    span
        (2, P) out: first azimuth and end for each solid of the body, as of `azimuth_span`.
    in_view, views
        (2, P), (2,) out: outer solids and inner solids, and their numbers.
    """
    views[0], views[1] = 0, 0
    for p in range(body_solid[a], body_solid[a + 1]):
        span[0, p], span[1, p] = azimuth_span(solid_bounds, p, local, azimuths, limits)
        inner = int(solid_inner[p])
        in_view[inner, views[inner]] = p
        views[inner] += span[0, p] < span[1, p]


@kernel(error_model="numpy")
def _cast_body(
    a: int, first: int, end: int, refine: bool, rays: Rays, bodies: Solids, local: Floats, longest: Floats, span: Ints,
    in_view: Ints, views: Ints, entry: Floats, leave: Floats, entry_plane: Ints, depth: Floats, plane: Ints,
    enter: Floats, through: Ints, on_pane: Bools, farthest: Floats, covered: Floats,
) -> int:  # fmt: skip
    """End the rays of azimuths [first, end) on body a; return the rays that would if it were alone on the ground.

    Parameters
    ----------
    longest
        (K,) largest length of a ray per length in plan.
    depth, plane, on_pane
        (L, R) work space: inverse depth, plane, and mask of the rays on panes.
    enter, through
        (2, R), (R,) work space of `enter_solid`.
    farthest
        (L,) work space: inverse depth that no ray of each beam falls below, or PASSED or HIDDEN [1/m].
    covered
        (K, L) in and out: inverse depth that no hit of each beam falls below [1/m].
    """
    line, side, slope, cos, far, hit, hit_id, on_ground = rays
    bounds, solid_plane, solid_bounds, planes = bodies.bounds, bodies.solid_plane, bodies.solid_bounds, bodies.planes
    transmission, alone, (_, layers, per_beam) = bodies.transmission, 0, slope.shape
    edge_cos, edge_sin = side[0, 0], abs(side[1, 0])
    flat, reach = len(on_ground) == 0, 1.0 / (far[first, 0, 0] * cos[first, 0, 0])
    for c in range(end - first):
        k = first + c
        nearest = longest[k] / plan_distance(bounds, a, local, c)
        countable = flat and farthest_distance(bounds, a, local, c) < reach
        for inner in range(2):  # outer solids, then those behind a pane
            least = PASSED
            for layer in range(layers):
                farthest[layer] = PASSED
            for j in range(views[inner]):
                p = in_view[inner, j]
                if not span[0, p] <= c < span[1, p]:
                    continue
                if least * plan_distance(solid_bounds, p, local, c) > longest[k]:
                    continue
                facing, hidden = split_planes(
                    planes, solid_plane[p], solid_plane[p + 1], local, c, entry, entry_plane, leave
                )
                for layer in range(layers if facing > 0 else 0):
                    low, high, at, most = slope[k, layer, 0], slope[k, layer, -1], NONE, HIDDEN
                    entries, exits = facing, hidden
                    if refine:
                        at = entry_of_corners(facing, hidden, entry, leave, edge_cos, edge_sin, low, high)
                    if at == MISSED or farthest[layer] == HIDDEN:
                        continue
                    # Above a flat ground and in range, rays on a hidden solid are counted without tracing.
                    if at >= 0 and countable and solid_bounds[p, 0, 2] >= 0.0 and nearest < covered[k, layer]:
                        farthest[layer] = HIDDEN
                        continue
                    if farthest[layer] == PASSED:
                        start_rays(k, layer, line, side, slope, far, on_ground, depth, plane)
                        farthest[layer] = 0.0
                    if at >= 0:
                        enter_through(at, entry, entry_plane[at], k, layer, side, slope, depth, plane)
                        far_edge, _ = depth_bounds(
                            entry[at, 0], entry[at, 1], entry[at, 2], edge_cos, edge_sin, low, high
                        )
                        farthest[layer] = max(farthest[layer], far_edge)
                        continue
                    if per_beam == 1:
                        enter_by_ray(facing, hidden, entry, entry_plane, leave, k, layer, slope, depth, plane)
                        farthest[layer] = depth[layer, 0]
                        if plane[layer, 0] != NONE and nearest < hit[INVERSE_DEPTH, k, layer, 0]:
                            farthest[layer] = HIDDEN  # with any solid
                        continue
                    if refine:
                        entries, exits, most = keep_relevant(
                            facing, hidden, entry, entry_plane, leave, edge_cos, edge_sin, low, high
                        )
                    if most > farthest[layer]:
                        enter_solid(
                            entries, exits, entry, entry_plane, leave, k, layer, side, slope, depth, plane, enter,
                            through,
                        )  # fmt: skip
                least = HIDDEN
                for layer in range(layers):
                    least = min(least, farthest[layer])
            panes = False
            for layer in range(layers):
                if inner:
                    look_inside(farthest[layer], on_pane, planes, local, c, k, layer, depth, plane, cos, hit, hit_id)
                    continue
                met, nearer = keep_nearer(
                    a, farthest[layer], planes, local, c, k, layer, depth, plane, cos, hit, hit_id
                )
                alone += met
                covered[k, layer] = max(covered[k, layer], farthest[layer] if nearer > 0 else 0.0)
                if views[1] > 0:
                    panes = find_panes(a, nearer, k, layer, transmission, hit_id, on_pane) or panes
            if not panes:
                break
    return alone


@kernel()
def _largest_group(offsets: Ints) -> int:
    """Return the size of the largest group; group g has members offsets[g] to offsets[g + 1]."""
    most = 0
    for g in range(len(offsets) - 1):
        most = max(most, offsets[g + 1] - offsets[g])
    return most

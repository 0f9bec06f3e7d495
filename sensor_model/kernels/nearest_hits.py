"""Nearest hits of the rays of one beam: on a body, on a pane of it, and inside of it behind the pane.

The functions are inlined, because a call costs an atomic reference count per array.
"""

import math

from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import (
    COSINE,
    INNER_COSINE,
    INNER_INVERSE_DEPTH,
    INNER_SURFACE,
    INVERSE_DEPTH,
    NONE,
    SURFACE,
    TARGET,
)

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

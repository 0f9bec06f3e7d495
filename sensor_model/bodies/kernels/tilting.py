"""Tilt of the planes and boxes of bodies by pitch and roll about the road under their pose."""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel

_ON_ROAD_M = 1e-6  # largest distance from the road of a solid that stands on it
_DOWN = -1.0 + 1e-9  # largest z of the normal of a sole


@kernel()
def tilt_solids(
    attitude: Floats, rotation: Floats, ground_z: Floats, body_solid: Ints, solid_plane: Ints, solid_bounds: Floats,
    planes: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:  # fmt: skip
    """Tilt the solids of A bodies and raise them; first extend solids that stand on the road, so that they reach it.

    A point p moves to R p + (0, 0, z), so a plane n . p = d becomes (R n) . p = d + (R n) . (0, 0, z).

    Parameters
    ----------
    attitude, rotation, ground_z
        (A, 2), (A, 3, 3) and (A,): pitch and roll [rad], their rotation R, and height z [m].
    body_solid, solid_plane, solid_bounds, planes
        As in `bodies.Bodies`, of level bodies.

    Returns
    -------
    (A, 2, 3) boxes around the bodies, (P, 2, 3) boxes around the solids, (Q, 4) planes, and (Q, 4) planes of the
    extended solids before the tilt.
    """
    bounds, tilted_bounds = np.empty((len(ground_z), 2, 3)), np.empty(solid_bounds.shape)
    tilted, extended = np.empty(planes.shape), planes.copy()
    for a in range(len(ground_z)):
        R = rotation[a]
        for p in range(body_solid[a], body_solid[a + 1]):
            below = _depth_below_road(solid_bounds[p], attitude[a])
            for q in range(solid_plane[p], solid_plane[p + 1]):
                if planes[q, 2] < _DOWN and planes[q, 3] >= -_ON_ROAD_M:
                    extended[q, 3] += below
                for axis in range(3):
                    tilted[q, axis] = (
                        R[axis, 0] * extended[q, 0] + R[axis, 1] * extended[q, 1] + R[axis, 2] * extended[q, 2]
                    )
                tilted[q, 3] = extended[q, 3] + tilted[q, 2] * ground_z[a]
            _tilt_box(solid_bounds[p], below, R, ground_z[a], tilted_bounds[p])
            first = p == body_solid[a]
            for axis in range(3):
                low, high = tilted_bounds[p, 0, axis], tilted_bounds[p, 1, axis]
                bounds[a, 0, axis] = low if first else min(low, bounds[a, 0, axis])
                bounds[a, 1, axis] = high if first else max(high, bounds[a, 1, axis])
    return bounds, tilted_bounds, tilted, extended


@kernel()
def _depth_below_road(box: Floats, attitude: Floats) -> float:
    """Return by how much a solid in a box that stands on the road is extended downwards [m]; 0 for other solids."""
    if box[0, 2] > _ON_ROAD_M:
        return 0.0
    reach_x, reach_y = max(-box[0, 0], box[1, 0]), max(-box[0, 1], box[1, 1])
    return float(reach_x * abs(elementary.tan(attitude[0])) + reach_y * abs(elementary.tan(attitude[1])))


@kernel()
def _tilt_box(box: Floats, below: float, R: Floats, ground_z: float, around: Floats) -> None:
    """Set the axis-aligned box (2, 3) around a box that is extended downwards, tilted and raised."""
    for axis in range(3):
        centre, half = ground_z if axis == 2 else 0.0, 0.0
        for k in range(3):
            low, high = box[0, k] - (below if k == 2 else 0.0), box[1, k]
            centre += R[axis, k] * 0.5 * (low + high)
            half += abs(R[axis, k]) * 0.5 * (high - low)
        around[0, axis], around[1, axis] = centre - half, centre + half

"""Overlaps of the bodies of one frame. A bent vehicle is the boxes of its sections."""

from typing import NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.articulated import parts
from luxloop.scenarios.grading.truth_events.bodies import Bodies
from luxloop.scenarios.grading.truth_events.event_limits import OVERLAP_M2


class Overlaps(NamedTuple):
    """K overlapping pairs of bodies."""

    first: Ints
    """(K,) row in `Bodies`; smaller than the other."""
    second: Ints
    """(K,) row of the other body."""
    area: Floats
    """(K,) [m^2]."""


def overlaps(bodies: Bodies) -> Overlaps:
    """Return the pairs whose overlap is larger than `OVERLAP_M2`."""
    row = np.arange(len(bodies.id))
    pose, size = bodies.pose_world, bodies.size
    if bodies.joint_angles.any():
        row, pose, size = parts(pose, size, bodies.joint_angles, bodies.kind)
    boxes = np.concatenate([pose, size], axis=1)
    first, second = _near_pairs(boxes, row)
    if not len(first):
        return Overlaps(first, second, np.empty(0))
    from luxloop.scenarios.grading.kernels.clipping import shared_areas  # numba takes half a second to import

    area = shared_areas(boxes[first], boxes[second])
    if not (area > 0.0).any():
        return Overlaps(first[:0], second[:0], area[:0])
    count = len(bodies.id)
    low, high = np.minimum(row[first], row[second]), np.maximum(row[first], row[second])
    pair, at = np.unique(low * count + high, return_inverse=True)
    total: Floats = np.bincount(at, weights=area, minlength=len(pair)).astype(np.float64)
    over = total > OVERLAP_M2
    return Overlaps(pair[over] // count, pair[over] % count, total[over])


def _near_pairs(boxes: Floats, row: Ints) -> tuple[Ints, Ints]:
    """Return the pairs of boxes (B, 5) of different bodies whose circumscribed circles overlap."""
    x, y = boxes[:, 0], boxes[:, 1]
    half = 0.5 * np.hypot(boxes[:, 3], boxes[:, 4])
    near = (x[:, None] - x) ** 2 + (y[:, None] - y) ** 2 < (half[:, None] + half) ** 2
    first, second = np.nonzero(near)
    kept = (first < second) & (row[first] != row[second])
    return first[kept], second[kept]

"""Turning the tractor of an articulated body about its kingpin, in the body's frame.

N kingpins stand at x [m] on the body's axis; angles [rad] are counter-clockwise.
"""

import numpy as np

from sensor_model.arrays import Floats


def turned_vectors(vectors: Floats, angle: Floats) -> Floats:
    """Turn vectors (N, 2) or (N, 3) in plan."""
    cos, sin = np.cos(angle), np.sin(angle)
    turned = vectors.copy()
    turned[:, 0] = cos * vectors[:, 0] - sin * vectors[:, 1]
    turned[:, 1] = sin * vectors[:, 0] + cos * vectors[:, 1]
    return turned


def turned_points(points: Floats, kingpin: Floats, angle: Floats) -> Floats:
    """Turn points (N, 2) about their kingpins (N,)."""
    pivot = np.column_stack([kingpin, np.zeros_like(kingpin)])
    return pivot + turned_vectors(points - pivot, angle)


def turned_planes(planes: Floats, kingpin: Floats, angle: Floats) -> Floats:
    """Turn planes (N, 4), normal and offset.

    What was at p is then at h + R (p - h), so n . p = d becomes (R n) . p = d - n . h + (R n) . h.
    """
    turned = turned_vectors(planes, angle)
    turned[:, 3] += (turned[:, 0] - planes[:, 0]) * kingpin
    return turned


def turned_boxes(boxes: Floats, kingpin: Floats, angle: Floats) -> Floats:
    """Boxes along the axes, lower and upper corner (N, 2, 3), around the turned boxes."""
    corners = [
        turned_points(np.column_stack([boxes[:, end, 0], boxes[:, side, 1]]), kingpin, angle)
        for end in (0, 1)
        for side in (0, 1)
    ]
    around = boxes.copy()
    around[:, 0, :2], around[:, 1, :2] = np.min(corners, axis=0), np.max(corners, axis=0)
    return around

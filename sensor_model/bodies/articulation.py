"""Rotation of the tractor of an articulated body about its kingpin, in the body's frame.

N kingpins are at x [m] on the body's axis; angles [rad] are counter-clockwise.
"""

import numpy as np

from sensor_model.arrays import Floats


def rotate_vectors(vectors: Floats, angle: Floats) -> Floats:
    """Rotate vectors (N, 2) or (N, 3) about z by angles (N,)."""
    cos, sin = np.cos(angle), np.sin(angle)
    rotated = vectors.copy()
    rotated[:, 0] = cos * vectors[:, 0] - sin * vectors[:, 1]
    rotated[:, 1] = sin * vectors[:, 0] + cos * vectors[:, 1]
    return rotated


def rotate_points(points: Floats, kingpin: Floats, angle: Floats) -> Floats:
    """Rotate points (N, 2) about their kingpins (N,)."""
    pivot = np.column_stack([kingpin, np.zeros_like(kingpin)])
    return pivot + rotate_vectors(points - pivot, angle)


def rotate_planes(planes: Floats, kingpin: Floats, angle: Floats) -> Floats:
    """Rotate planes (N, 4), normal and offset, about their kingpins (N,).

    A point p moves to h + R (p - h), so n . p = d becomes (R n) . p = d - n . h + (R n) . h.
    """
    rotated = rotate_vectors(planes, angle)
    rotated[:, 3] += (rotated[:, 0] - planes[:, 0]) * kingpin
    return rotated


def rotate_boxes(boxes: Floats, kingpin: Floats, angle: Floats) -> Floats:
    """Return axis-aligned boxes (N, 2, 3), lower and upper corner, around the rotated boxes."""
    corners = [
        rotate_points(np.column_stack([boxes[:, end, 0], boxes[:, side, 1]]), kingpin, angle)
        for end in (0, 1)
        for side in (0, 1)
    ]
    around = boxes.copy()
    around[:, 0, :2], around[:, 1, :2] = np.min(corners, axis=0), np.max(corners, axis=0)
    return around

"""Rotation of bodies: by pitch and roll, and of the sections of an articulated body about their joints.

A joint is given by its x [m] on the axis of the straight body, and its x, y [m] in the bent body, which differ where
further joints are between it and the section that defines the pose. Angles [rad] are counter-clockwise.
"""

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats


def tilt_rotations(attitude: Floats) -> Floats:
    """Return (N, 3, 3) rotations R of attitudes (N, 2), as in `luxloop.sim.world.Actors`: level = R body.

    The pitch is about y, then the roll about x; the axes of the level frame are those of a body without both.
    """
    (cp, cr), (sp, sr) = elementwise.cos(attitude).T, elementwise.sin(attitude).T
    zero = np.zeros_like(cp)
    rows = [[cp, sp * sr, sp * cr], [zero, cr, -sr], [-sp, cp * sr, cp * cr]]
    return np.ascontiguousarray(np.array(rows).transpose(2, 0, 1))


def rotate_vectors(vectors: Floats, angle: Floats) -> Floats:
    """Rotate vectors (N, 2) or (N, 3) about z by angles (N,)."""
    cos, sin = elementwise.cos(angle), elementwise.sin(angle)
    rotated = vectors.copy()
    rotated[:, 0] = cos * vectors[:, 0] - sin * vectors[:, 1]
    rotated[:, 1] = sin * vectors[:, 0] + cos * vectors[:, 1]
    return rotated


def rotate_points(points: Floats, pivot: Floats, angle: Floats) -> Floats:
    """Rotate points (N, 2) about their joints (N, 3)."""
    before = np.column_stack([pivot[:, 0], np.zeros(len(pivot))])
    return pivot[:, 1:] + rotate_vectors(points - before, angle)


def rotate_planes(planes: Floats, pivot: Floats, angle: Floats) -> Floats:
    """Rotate planes (N, 4), normal and offset, about their joints (N, 3).

    A point p moves to m + R (p - h), so n . p = d becomes (R n) . p = d - n . h + (R n) . m.
    """
    rotated = rotate_vectors(planes, angle)
    rotated[:, 3] += rotated[:, 0] * pivot[:, 1] + rotated[:, 1] * pivot[:, 2] - planes[:, 0] * pivot[:, 0]
    return rotated


def rotate_boxes(boxes: Floats, pivot: Floats, angle: Floats) -> Floats:
    """Return axis-aligned boxes (N, 2, 3), lower and upper corner, around the rotated boxes."""
    corners = [
        rotate_points(np.column_stack([boxes[:, end, 0], boxes[:, side, 1]]), pivot, angle)
        for end in (0, 1)
        for side in (0, 1)
    ]
    around = boxes.copy()
    around[:, 0, :2], around[:, 1, :2] = np.min(corners, axis=0), np.max(corners, axis=0)
    return around

"""Plane geometry for grading, implemented independently of the tracker's so that no bug is shared.

Angles are in radians, counter-clockwise. A pose is (x, y, yaw); a box is (x, y, yaw, length, width) about its centre.
"""

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats, Ints

QUARTER = np.pi / 2
CORNER_SIGNS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
"""Front left, rear left, rear right, front right: counter-clockwise."""


def wrap(angle: Floats, period: float = 2 * np.pi) -> Floats:
    """Wrap angles to (-period / 2, period / 2]."""
    return angle - period * np.ceil(angle / period - 0.5)


def turned(vectors: Floats | Ints, angle: Floats | float) -> Floats:
    """Rotate vectors (..., 2) by angles (...)."""
    cos, sin = elementwise.cos(angle), elementwise.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    first = cos * x - sin * y
    out = np.empty((*first.shape, 2))
    out[..., 0], out[..., 1] = first, sin * x + cos * y
    return out


def into_frame(poses: Floats, frame: Floats) -> Floats:
    """Transform poses (N, 3) from the parent frame of `frame` (3,) into `frame`."""
    out = np.empty_like(poses)
    out[:, :2] = turned(poses[:, :2] - frame[:2], -frame[2])
    out[:, 2] = wrap(poses[:, 2] - frame[2])
    return out


def out_of_frame(poses: Floats, frame: Floats) -> Floats:
    """Transform poses (N, 3) from `frame` (3,) into its parent frame: the inverse of `into_frame`."""
    out = np.empty_like(poses)
    out[:, :2] = turned(poses[:, :2], frame[2]) + frame[:2]
    out[:, 2] = wrap(poses[:, 2] + frame[2])
    return out


def corner(boxes: Floats, sign: Ints) -> Floats:
    """Return corners (..., 2) of boxes (..., 5), given by signs (..., 2) along the boxes' axes."""
    return boxes[..., :2] + turned(0.5 * sign * boxes[..., 3:], boxes[..., 2])


def nearest_sign(boxes: Floats) -> Ints:
    """Return the signs (N, 2) of the corner of each box (N, 5) nearest to the origin."""
    origin = turned(-boxes[:, :2], -boxes[:, 2])
    return np.where(origin >= 0, 1, -1)


def matching_sign(sign: Ints, turn: Floats) -> Ints:
    """Return the signs of the same corner in another box's frame.

    The headings of the two boxes may differ by quarter turns, because a tracker may take a side for the front. The
    nearest quarter turn relates the corners.

    Parameters
    ----------
    sign
        (N, 2) corner in the frame of its box.
    turn
        (N,) heading of that box minus heading of the other [rad].

    Returns
    -------
    (N, 2) signs in the other box's frame.
    """
    quarters = np.round(turn / QUARTER)
    return np.rint(turned(sign, quarters * QUARTER)).astype(np.int64)


def iou(a: Floats, b: Floats) -> Floats:
    """Bird's-eye intersection over union of boxes `a` (N, 5) and `b` (N, 5), row by row; 0 for empty or NaN boxes."""
    out = np.zeros(len(a))
    area_a, area_b = a[:, 3] * a[:, 4], b[:, 3] * b[:, 4]
    sound = np.flatnonzero(np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1) & (area_a > 0) & (area_b > 0))
    if not len(sound):
        return out
    from luxloop.scenarios.grading.kernels.clipping import shared_areas  # numba takes half a second to import

    shared = shared_areas(a[sound], b[sound])
    out[sound] = np.minimum(shared / (area_a[sound] + area_b[sound] - shared), 1.0)
    return out


def iou_table(a: Floats, b: Floats) -> Floats:
    """(A, B) bird's-eye intersection over union of every box of `a` (A, 5) with every box of `b` (B, 5)."""
    reach = 0.5 * (elementwise.hypot(a[:, 3], a[:, 4])[:, None] + elementwise.hypot(b[:, 3], b[:, 4]))
    gap = elementwise.hypot(a[:, None, 0] - b[:, 0], a[:, None, 1] - b[:, 1])
    row, column = np.nonzero(gap < reach)
    table = np.zeros((len(a), len(b)))
    table[row, column] = iou(a[row], b[column])
    return table

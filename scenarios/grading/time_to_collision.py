"""Time to collision of two boxes that keep their velocities and headings."""

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.plane_geometry import turned

ROUNDING_MPS = 1e-9
"""[m/s] Speeds below this are rounding errors of equal velocities; a metre would take 30 years."""


def time_to_collision(a: Floats, velocity_a: Floats, b: Floats, velocity_b: Floats) -> Floats:
    """Return the time until two boxes touch, if both keep velocity and heading.

    Two rectangles overlap if their projections overlap on each of their four axes (separating axis theorem). On each
    axis the projections of moving boxes overlap during one interval of time, and the boxes during the common part.

    Parameters
    ----------
    a, b
        (N, 5) boxes: x [m], y [m], yaw [rad], length [m], width [m].
    velocity_a, velocity_b
        (N, 2) velocities in the same frame [m/s].

    Returns
    -------
    (N,) time [s]; 0 for boxes that overlap, infinite for those that never will.
    """
    begin, end = np.full(len(a), -np.inf), np.full(len(a), np.inf)
    for yaw in (a[:, 2], a[:, 2] + 0.5 * np.pi, b[:, 2], b[:, 2] + 0.5 * np.pi):
        distance = turned(b[:, :2] - a[:, :2], -yaw)[:, 0]
        speed = turned(velocity_b - velocity_a, -yaw)[:, 0]
        reach = _half_extent(a, yaw) + _half_extent(b, yaw)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossings = np.sort([(-reach - distance) / speed, (reach - distance) / speed], axis=0)
        resting = np.abs(speed) < ROUNDING_MPS
        always = np.where(np.abs(distance) < reach, np.inf, -np.inf)
        begin = np.maximum(begin, np.where(resting, -always, crossings[0]))
        end = np.minimum(end, np.where(resting, always, crossings[1]))
    return np.where((begin < end) & (end > 0.0), np.maximum(begin, 0.0), np.inf)


def _half_extent(boxes: Floats, yaw: Floats) -> Floats:
    """(N,) half extents of boxes (N, 5) along axes with the angles `yaw` (N,) [m]."""
    turn = boxes[:, 2] - yaw
    half: Floats = 0.5 * (boxes[:, 3] * np.abs(np.cos(turn)) + boxes[:, 4] * np.abs(np.sin(turn)))
    return half

"""Removal of articulation from points and vectors in the frame of a body."""

import math

from numba import njit


@njit(cache=True, inline="always")
def turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """Rotate a vector about z, counter-clockwise [rad]."""
    if angle == 0.0:  # as of most planes
        return x, y
    cos, sin = math.cos(angle), math.sin(angle)
    return cos * x - sin * y, sin * x + cos * y


@njit(cache=True, inline="always")
def straight_point(x: float, y: float, turn: float, kingpin: float) -> tuple[float, float]:
    """Return a point on a plane that is rotated by `turn` [rad] about the kingpin (kingpin, 0) before that rotation."""
    if turn == 0.0:
        return x, y
    back_x, back_y = turned(x - kingpin, y, -turn)
    return kingpin + back_x, back_y

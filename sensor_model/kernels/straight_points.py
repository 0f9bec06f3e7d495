"""Removal of articulation from points and vectors in the frame of a body."""

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel


@kernel(inline="always")
def turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """Rotate a vector about z, counter-clockwise [rad]."""
    if angle == 0.0:  # as of most planes
        return x, y
    cos, sin = elementary.cos(angle), elementary.sin(angle)
    return cos * x - sin * y, sin * x + cos * y


@kernel(inline="always")
def straight_point(x: float, y: float, turn: float, pivot: Floats) -> tuple[float, float]:
    """Return a point on a plane that is rotated by `turn` [rad] before that rotation.

    The rotation moved the joint (pivot[0], 0) to (pivot[1], pivot[2]) [m].
    """
    if turn == 0.0:
        return x, y
    back_x, back_y = turned(x - pivot[1], y - pivot[2], -turn)
    return pivot[0] + back_x, back_y

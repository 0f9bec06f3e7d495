"""Positions of ego and bodies around the frame's time, and of points on bent bodies before they were bent.

Accelerations and yaw rates are constant.
"""

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import EgoDrive


@kernel(inline="always")
def ego_at(drive: EgoDrive, time: float) -> tuple[float, float]:
    """Return the ego's displacement since the frame's time, x and y in the ego frame [m]."""
    half = 0.5 * time * time
    return drive.vx * time + drive.ax * half, drive.vy * time + drive.ay * half


@kernel(inline="always")
def body_at(motion: Floats, a: int, time: float) -> tuple[float, float]:
    """Return the position of body a at a time, x and y in the ego frame [m]; `motion` as in `records.Solids`."""
    half = 0.5 * time * time
    x = motion[a, 0] + motion[a, 3] * time + motion[a, 5] * half
    y = motion[a, 1] + motion[a, 4] * time + motion[a, 6] * half
    return x, y


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

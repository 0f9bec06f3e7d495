"""Motion of ego and bodies around the frame's time: constant acceleration and constant yaw rate."""

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

"""Kernel that stores a raw frame and detects jumps across lanes."""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sim.physical.kernels.records import BodyDimensions, RawHistory
from luxloop.sim.physical.limits import CORNER, JUMP_LONGEST, JUMP_SPEED, LEAST_STEP


@kernel()
def store_frame(
    frame: int,
    rows: Ints,
    pose: Floats,
    speed: Floats,
    history: RawHistory,
    dimensions: BodyDimensions,
    rolling: bool,
    dt: float,
) -> Floats:
    """Store a raw frame; return the lateral jump (N,) [m] of each body, positive to the left, 0 without a jump.

    Parameters
    ----------
    frame
        Number of the frame.
    rows
        (N,) rows of the bodies.
    pose
        (N, 3) poses of the box centres.
    speed
        (N,) [m/s].
    history
        Raw history; written.
    dimensions
        Dimensions of the bodies.
    rolling
        Bodies follow the path with their fronts, see `PhysicalTruth`.
    dt
        Time between frames [s].
    """
    length = history.frame.shape[1]
    row, before = frame % length, (frame - 1) % length
    jump = np.zeros(len(rows))
    for n in range(len(rows)):
        body, yaw = rows[n], pose[n, 2]
        ahead = 0.5 * dimensions.length[body] if rolling else 0.0
        raw, path = history.raw[body, row], history.path[body, row]
        raw[0], raw[1], raw[2] = pose[n, 0] + ahead * elementary.cos(yaw), pose[n, 1] + ahead * elementary.sin(yaw), yaw
        path[:] = raw
        history.speed[body, row] = speed[n]
        history.frame[body, row] = frame
        history.changes_lane[body, row] = False
        if rolling and history.frame[body, before] == frame - 1:
            path[2], jump[n] = _step_course(history.raw[body, before], raw, history.path[body, before, 2], dt)
            if history.frame[body, (frame - 2) % length] != frame - 2:
                # the first step of a new body defines its course before; until now it was the simulator's yaw
                history.path[body, before, 2] = path[2]
    return jump


@kernel()
def _step_course(start: Floats, end: Floats, before: float, dt: float) -> tuple[float, float]:
    """Return the course [rad] of a step, and its lateral jump [m], positive to the left, 0 without a jump.

    A body that jumped, or hardly moved, keeps the course `before`. SUMO's angle is no substitute: after a jump it
    points diagonally across both lanes.
    """
    x, y = end[0] - start[0], end[1] - start[1]
    cos, sin = elementary.cos(before), elementary.sin(before)
    across, along = y * cos - x * sin, x * cos + y * sin
    if JUMP_SPEED * dt + CORNER * abs(along) < abs(across) <= JUMP_LONGEST:
        return before, across
    if x * x + y * y > LEAST_STEP**2:
        return elementary.atan2(y, x), 0.0
    return before, 0.0

"""Taking in what the simulator says of a frame."""

import math

import numpy as np
from numba import njit

from sim.arrays import Floats, Ints
from sim.physical.kernels.records import Builds, Said
from sim.physical.limits import CORNER, JUMP_LONGEST, JUMP_SPEED, LEAST_STEP


@njit(cache=True)
def note(
    frame: int, rows: Ints, pose: Floats, speed: Floats, said: Said, builds: Builds, leads: bool, dt: float
) -> Floats:
    """Enter a frame, and return how far (N,) [m] to the left each body jumped; 0 for most.

    Parameters
    ----------
    frame
        Its number.
    rows
        (N,) of the bodies.
    pose
        (N, 3) of their box centres.
    speed
        (N,) [m/s].
    said
        What is known; written.
    builds
        Of the bodies.
    leads
        Whether bodies are led by their fronts.
    dt
        Time between frames [s].
    """
    length = said.frame.shape[1]
    row, before = frame % length, (frame - 1) % length
    jump = np.zeros(len(rows))
    for n in range(len(rows)):
        body, yaw = rows[n], pose[n, 2]
        ahead = 0.5 * builds.length[body] if leads else 0.0
        raw, path = said.raw[body, row], said.path[body, row]
        raw[0], raw[1], raw[2] = pose[n, 0] + ahead * math.cos(yaw), pose[n, 1] + ahead * math.sin(yaw), yaw
        path[:] = raw
        said.speed[body, row] = speed[n]
        said.frame[body, row] = frame
        said.changes_lane[body, row] = False
        if leads and said.frame[body, before] == frame - 1:
            path[2], jump[n] = _course(said.raw[body, before], raw, said.path[body, before, 2], dt)
            if said.frame[body, (frame - 2) % length] != frame - 2:
                # where somebody new came from is where the first step leads; so far the simulator's yaw had to do
                said.path[body, before, 2] = path[2]
    return jump


@njit(cache=True)
def _course(start: Floats, end: Floats, before: float, dt: float) -> tuple[float, float]:
    """Return the course [rad] of a step, and how far it jumped to the left [m], 0 if it did not.

    Who jumped, or hardly moved, keeps the course of `before`. SUMO's own angle will not do for it: after a jump it is
    that of a body askew across both lanes.
    """
    x, y = end[0] - start[0], end[1] - start[1]
    cos, sin = math.cos(before), math.sin(before)
    across, along = y * cos - x * sin, x * cos + y * sin
    if JUMP_SPEED * dt + CORNER * abs(along) < abs(across) <= JUMP_LONGEST:
        return before, across
    if x * x + y * y > LEAST_STEP**2:
        return math.atan2(y, x), 0.0
    return before, 0.0

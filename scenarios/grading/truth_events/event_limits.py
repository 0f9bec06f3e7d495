"""Limits from which the ground truth is called an event, and the times for which actors are not graded."""

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.sim.world import Kind

OVERLAP_M2 = 0.05
"""[m^2] Least overlap of two boxes that is an overlap of bodies. Corners of bodies are rounded: at a radius of 0.5 m a
box is (1 - pi / 4) r^2 = 0.054 m^2 larger than the body at each corner."""

JUMP_M = 1.0
"""[m] Least distance between a body and the place its velocity leads to that is a teleport. Within a frame of 0.08 s,
10 m/s^2 account for 0.03 m."""

ACCELERATION_MPS2 = 10.0
"""[m/s^2] Longitudinal and lateral together: the grip of good tyres on a dry road (Kamm's circle)."""

JERK_MPS3 = 60.0
"""[m/s^3] Twice the truth layer's limit along (`sim.physical.limits.JERK`). An emergency brake of 9 m/s^2 builds up in
0.15 s or more."""

YAW_RATE_RADPS = 1.5
"""[rad/s] Of bodies on wheels: a car on its smallest turning circle of 5 m radius at 7.5 m/s, with 11 m/s^2."""

ON_WHEELS = np.array([kind not in (Kind.PEDESTRIAN, Kind.OBSTACLE) for kind in Kind])
"""True for kinds with a limit of the yaw rate, by `Kind`; people turn on the spot."""

EPISODE_S = 1.0
"""[s] Two overlaps or violations of the same bodies are one event if the time between them is at most this long."""

REAPPEARANCE_S = 1.0
"""[s] Longest time between the end of an actor and its continuation with another id."""

SAME_SIZE_M = 0.01
"""[m] Largest difference between the sizes of one body."""

MASK_S = 1.0
"""[s] Time for which an actor that was inserted or moved in view is not graded, and for which tracks at the place of a
removed one are not false. A vehicle on a real road comes into view by degrees: at 5 m/s, 5 m of length take 1 s, and a
tracker confirms it meanwhile. `luxloop.scenarios.grading.snapshots` allows the same time for confirmation."""

FRINGE_M = 10.0
"""[m] Actors enter and leave at the border of the delivered range. They do not within this distance of it."""

LIMITS = {
    "acceleration_mps2": ACCELERATION_MPS2,
    "jerk_mps3": JERK_MPS3,
    "yaw_rate_radps": YAW_RATE_RADPS,
}
"""Limit of each checked quantity."""


def exceedance(values: Floats) -> Floats:
    """Return values (M, 3) of the quantities in `LIMITS`, in units of their limits."""
    excess: Floats = values / np.array(list(LIMITS.values()))
    return excess

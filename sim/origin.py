"""Where the world frame's origin lies: near the ego, so that float32 tells millimetres there."""

import numpy as np

from sim.arrays import Floats

STEP_M = 10_000.0
"""Full, so that people recognise their maps; zero for the usual small one."""


def origin_near(place: Floats) -> Floats:
    """Return the multiple (2,) of `STEP_M` nearest to the ego's first place (2,) in the simulator's coordinates [m]."""
    return np.round(place / STEP_M) * STEP_M + 0.0  # never -0

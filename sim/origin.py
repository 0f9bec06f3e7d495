"""Origin of the world frame: near the ego, so that float32 resolves millimetres there."""

import numpy as np

from luxloop.arrays import Floats

STEP_M = 10_000.0
"""[m] Grid of possible origins: round numbers keep coordinates recognisable; small maps keep the origin (0, 0)."""


def origin_near(place: Floats) -> Floats:
    """Return the multiple (2,) of `STEP_M` nearest to the ego's first position (2,), in simulator coordinates [m]."""
    return np.round(place / STEP_M) * STEP_M + 0.0  # adding 0.0 turns -0 into 0

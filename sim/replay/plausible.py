"""Plausibility of a recording: numbers far beyond road traffic mean wrong units or a damaged file."""

import numpy as np

from luxloop.arrays import Bools, Floats
from luxloop.sim.replay.recording import Recording
from luxloop.sim.source import TrafficInputError

LATEST_S = 1e11
"""[s] Clocks count from 1970 at most: 2e9 s. Milliseconds and shorter units are larger."""
FARTHEST_M = 1e8
"""[m] Coordinates of any projection of the Earth are smaller."""
LARGEST_YAW = 1e4
"""[rad] Yaws may be unwrapped."""
SMALLEST_M, LARGEST_M = 0.05, 200.0
"""[m] Sizes of road users."""


def require_plausible(recording: Recording) -> None:
    """Check times, positions, yaws and sizes.

    Raises
    ------
    TrafficInputError
        One is not finite or out of range; the message names the road user.
    """
    x, y, yaw = recording.pose.T
    _require(recording, "time", recording.time, np.abs(recording.time) <= LATEST_S, f"within {LATEST_S:g} s")
    for name, values in (("x", x), ("y", y)):
        _require(recording, name, values, np.abs(values) <= FARTHEST_M, f"within {FARTHEST_M:g} m")
    _require(recording, "yaw", yaw, np.isnan(yaw) | (np.abs(yaw) <= LARGEST_YAW), f"within {LARGEST_YAW:g} rad")
    for user in recording.users:
        if not all(SMALLEST_M <= side <= LARGEST_M for side in user.size):
            sides = " x ".join(f"{side:g}" for side in user.size)
            raise TrafficInputError(
                f'"{user.name}" is {sides} m large; should be {SMALLEST_M:g} to {LARGEST_M:g} m along each side'
            )


def _require(recording: Recording, name: str, values: Floats, good: Bools, remedy: str) -> None:
    if not good.all():
        at = int(np.argmin(good))
        user = recording.users[recording.user[at]].name
        raise TrafficInputError(f'"{user}": {name} = {values[at]:g}: should be a number {remedy}; correct the file')

"""Where the ego believes it is."""

import math

import numpy as np
import numpy.typing as npt

from sensor_model.bodies import relative_pose

Floats = npt.NDArray[np.float64]


class Odometry:
    """Ego pose relative to the first one seen. Exact for now: dead reckoning does not drift."""

    def __init__(self) -> None:
        self._start_world: Floats | None = None

    def pose(self, ego_pose_world: Floats) -> Floats:
        """Return (3,) x, y [m] and yaw in [-pi, pi] [rad] in the odometry frame."""
        if self._start_world is None:
            self._start_world = ego_pose_world.copy()
        x, y, yaw = relative_pose(ego_pose_world, self._start_world)
        return np.array([x, y, math.remainder(yaw, 2.0 * math.pi)])

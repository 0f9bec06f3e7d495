"""Odometry of the ego: its measured pose."""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.sensor_model.bodies.scene import relative_pose
from luxloop.sensor_model.noise.odometry_drift import OdometryNoise
from luxloop.sensor_model.noise.random_draws import Draws, Purpose

_RUN = 0  # frame number of draws made once per run


class Odometry:
    """Ego pose relative to the first one, accumulated from noisy motion measurements.

    Call `pose` in the order of time: each error depends on all earlier ones.
    """

    def __init__(self, noise: OdometryNoise, draws: Draws) -> None:
        self._noise = noise
        self._draws = draws
        scale, offset = (float(draws.normal_of(_RUN, k, 0, Purpose.ODOMETRY)[0]) for k in (0, 1))
        self._scale = 1.0 + noise.speed_scale_sigma * scale
        self._yaw_rate = math.radians(noise.yaw_rate_sigma_dps) * offset
        self._start_world: Floats | None = None
        self._last: tuple[float, Floats] | None = None
        self._pose = np.zeros(3)

    def pose(self, ego_pose_world: Floats, time: float, frame: int) -> Floats:
        """Return the pose (3,) in the odometry frame at a time [s]: x, y [m], yaw in [-pi, pi] [rad]."""
        if not self._noise.enabled:
            if self._start_world is None:
                self._start_world = ego_pose_world.copy()
            return _wrapped(relative_pose(ego_pose_world, self._start_world))
        if self._last is not None:
            last_time, last_pose = self._last
            self._add(relative_pose(ego_pose_world, last_pose), time - last_time, frame)
        self._last = time, ego_pose_world.copy()
        return self._pose.copy()

    def _add(self, motion: Floats, dt: float, frame: int) -> None:
        """Add a motion (3,) in the previous ego frame, over `dt` [s], with its measurement error."""
        walk = math.radians(self._noise.yaw_walk_sigma_deg) * math.sqrt(dt)
        turn = motion[2] + self._yaw_rate * dt + walk * float(self._draws.normal_of(frame, 0, 0, Purpose.YAW_WALK)[0])
        x, y, yaw = self._pose
        dx, dy = self._scale * motion[:2]
        cos, sin = elementary.cos(yaw), elementary.sin(yaw)
        self._pose = _wrapped(np.array([x + cos * dx - sin * dy, y + sin * dx + cos * dy, yaw + turn]))


def _wrapped(pose: Floats) -> Floats:
    x, y, yaw = pose
    return np.array([x, y, math.remainder(yaw, 2.0 * math.pi)])

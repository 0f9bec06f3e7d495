"""Extended Kalman filter of a two-axle (bicycle) state, as in Autoware's vehicle tracker.

State: x, y of the centre [m], yaw [rad], speed along the velocity [m/s], slip angle at the centre [rad]. With the
distance l from the centre to the rear axle, and the rear wheels rolling without slip,

    x' = v cos(yaw + slip),  y' = v sin(yaw + slip),  yaw' = v / l sin(slip)

(Rajamani 2012, Vehicle Dynamics and Control, section 2.2). The noise is white in acceleration and in slip rate.
"""

import math
from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Floats
from luxloop.tracker.geometry import wrap

REAR_SHARE = 0.3
"""Distance from the centre to the rear axle, as a share of the length: 1.35 m for a car."""
FIRST_SPEED_STD_MPS, FIRST_SLIP_STD_RAD = 10.0, 0.05
SLIP_MAX_RAD = 0.5
MEASURED: Floats = np.eye(3, 5)


@dataclass(slots=True)
class BicycleFilter:
    """State of a vehicle with its covariance."""

    mean: Floats
    """(5,)."""
    covariance: Floats
    """(5, 5)."""

    @classmethod
    def start(cls, center: Floats, heading: float, noise: Floats) -> "BicycleFilter":
        """Return the filter of a new vehicle; `noise` (3,) are the standard deviations of x, y and yaw."""
        std = [*noise, FIRST_SPEED_STD_MPS, FIRST_SLIP_STD_RAD]
        return cls(np.array([*center, heading, 0.0, 0.0]), np.diag(np.square(std)))

    @property
    def velocity(self) -> Floats:
        """(2,) [m/s]."""
        angle = self.mean[2] + self.mean[4]
        return np.asarray(self.mean[3] * np.array([math.cos(angle), math.sin(angle)]))

    def predict(self, dt: float, length_m: float, acceleration_std: float, slip_rate_std: float) -> None:
        """Move the vehicle by `dt` [s]."""
        _, _, yaw, v, slip = self.mean
        cos, sin, rear = math.cos(yaw + slip), math.sin(yaw + slip), REAR_SHARE * length_m
        jacobian = np.eye(5)
        jacobian[0, 2:] += dt * np.array([-v * sin, cos, -v * sin])
        jacobian[1, 2:] += dt * np.array([v * cos, sin, v * cos])
        jacobian[2, 3:] += dt * np.array([math.sin(slip), v * math.cos(slip)]) / rear
        self.mean = self.mean + dt * np.array([v * cos, v * sin, v * math.sin(slip) / rear, 0.0, 0.0])
        along = np.array([0.5 * dt**2 * cos, 0.5 * dt**2 * sin, 0.0, dt, 0.0]) * acceleration_std
        across = np.array([0.0, 0.0, 0.5 * dt**2 * v * math.cos(slip) / rear, 0.0, dt]) * slip_rate_std
        added = np.outer(along, along) + np.outer(across, across)
        self.covariance = jacobian @ self.covariance @ jacobian.T + added

    def residual(self, center: Floats, heading: float) -> Floats:
        """Return the difference (3,) of a measurement, whose heading is modulo half a turn, to the state."""
        turn = wrap(2.0 * (heading - self.mean[2])) / 2.0
        return np.array([*(center - self.mean[:2]), turn])

    def distance(self, center: Floats, noise: Floats) -> float:
        """Return the Mahalanobis distance of a measured centre."""
        spread = self.covariance[:2, :2] + np.diag(noise[:2] ** 2)
        away = center - self.mean[:2]
        return math.sqrt(float(away @ np.linalg.solve(spread, away)))

    def update(self, center: Floats, heading: float, noise: Floats) -> None:
        """Update by a measurement with standard deviations `noise` (3,)."""
        spread = MEASURED @ self.covariance @ MEASURED.T + np.diag(noise**2)
        gain = np.linalg.solve(spread, MEASURED @ self.covariance).T
        self.mean = self.mean + gain @ self.residual(center, heading)
        self.covariance = self.covariance - gain @ spread @ gain.T
        if self.mean[3] < 0.0:  # drives forwards: the front was at the other end
            self.mean[2], self.mean[3] = self.mean[2] + math.pi, -self.mean[3]
            self.covariance[3] *= -1.0
            self.covariance[:, 3] *= -1.0
        self.mean[2], self.mean[4] = wrap(self.mean[2]), float(np.clip(self.mean[4], -SLIP_MAX_RAD, SLIP_MAX_RAD))

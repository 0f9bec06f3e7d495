"""The Kalman filters of the bank, equations (6) to (9), on filterpy.

All three models are one chain of integrators per axis, cut at position, velocity or acceleration, so that one
builder serves them. Heading and yaw rate are uncoupled from position in (9): they are filtered once per track.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import KalmanFilter

from tracker.geometry import mahalanobis
from tracker.records import MODELS, Floats


@dataclass(frozen=True, slots=True)
class FilterConfig:
    """Noise of the filter bank; process noise is what each model does not know of a car's motion."""

    drift_std_mps: float = 0.1
    """Stationary model: how fast the seen corner of a standing vehicle may wander [m/s]."""
    acceleration_std_mps2: float = 1.5
    """Constant velocity model: acceleration it does not know [m/s^2]."""
    jerk_std_mps3: float = 6.0
    """Constant acceleration model: jerk it does not know [m/s^3]."""
    yaw_acceleration_std_radps2: float = 0.6
    """Heading filter [rad/s^2]."""
    position_std_floor_m: float = 0.1
    """Corner noise that the fit cannot know: rounded corners, points between beams [m]."""
    heading_std_floor_rad: float = 0.02
    """Heading noise that the fit cannot know [rad]."""
    initial_speed_std_mps: float = 8.0
    """Speed of a vehicle before it was seen twice [m/s]."""
    initial_acceleration_std_mps2: float = 1.5
    """Its acceleration [m/s^2]."""
    initial_yaw_rate_std_radps: float = 0.2
    """Its yaw rate [rad/s]."""

    def __post_init__(self) -> None:
        if min(self.position_std_floor_m, self.heading_std_floor_rad) <= 0:
            raise ValueError("position_std_floor_m and heading_std_floor_rad must be above 0")


def integrator(order: int, dt: float) -> Floats:
    """(order, order) transition of a chain of integrators: the one-axis block of (7), (8) and (9)."""
    chain = np.eye(order)
    if order > 1:
        chain[0, 1] = dt
    if order > 2:
        chain[1, 2], chain[0, 2] = dt, dt**2 / 2
    return chain


def process_noise(order: int, dt: float, config: FilterConfig) -> Floats:
    """(order, order) one-axis noise: the first derivative the model leaves out is white from step to step.

    Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation" (2001), 6.3.
    """
    if order == 1:
        return np.array([[(config.drift_std_mps * dt) ** 2]])
    std = config.acceleration_std_mps2 if order == 2 else config.jerk_std_mps3 * dt
    return np.asarray(Q_discrete_white_noise(dim=order, dt=dt, var=std**2))


def position_filter(order: int, position: Floats, covariance: Floats, config: FilterConfig) -> KalmanFilter:
    """Build one model of the bank: state (x, y), (x, y, vx, vy) or (x, y, vx, vy, ax, ay), measured in (x, y).

    Parameters
    ----------
    order
        1 stationary (7), 2 constant velocity (8), 3 constant acceleration (9).
    position, covariance
        (2,) [m] and (2, 2) [m^2] of the first observation.
    """
    kf = KalmanFilter(dim_x=2 * order, dim_z=2)
    kf.x = np.zeros(2 * order)
    kf.x[:2] = position
    kf.H = np.eye(2, 2 * order)
    spread = (0.0, config.initial_speed_std_mps, config.initial_acceleration_std_mps2)[:order]
    kf.P = np.kron(np.diag(np.square(spread)), np.eye(2))
    kf.P[:2, :2] = covariance
    return kf


def heading_filter(heading: float, variance: float, config: FilterConfig) -> KalmanFilter:
    """Build the heading block of (9), state (heading, yaw rate); here yaw rate does turn the heading."""
    kf = KalmanFilter(dim_x=2, dim_z=1)
    kf.x = np.array([heading, 0.0])
    kf.H = np.array([[1.0, 0.0]])
    kf.P = np.diag([variance, config.initial_yaw_rate_std_radps**2])
    return kf


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Transition and process noise of every filter for one time step; the same for all tracks."""

    dt: float
    """[s]."""
    models: list[tuple[Floats, Floats]]
    """Transition F and noise Q of each model of the bank."""
    heading: tuple[Floats, Floats]
    """F and Q of the heading filter."""


@lru_cache(maxsize=8)
def motion(dt: float, config: FilterConfig) -> Motion:
    """Equations (7), (8) and (9) for a time step `dt` [s]; remembered, since scans come at a steady rate."""
    axes = np.eye(2)
    return Motion(
        dt=dt,
        models=[
            (
                np.asarray(np.kron(integrator(order, dt), axes)),
                np.asarray(np.kron(process_noise(order, dt, config), axes)),
            )
            for order in range(1, len(MODELS) + 1)
        ],
        heading=(integrator(2, dt), Q_discrete_white_noise(2, dt, config.yaw_acceleration_std_radps2**2)),
    )


class Bank:
    """Every filter of one track: three of position, one of heading."""

    def __init__(self, position: Floats, heading: float, covariance: Floats, config: FilterConfig) -> None:
        self.models = [
            position_filter(order, position, covariance[:2, :2], config) for order in range(1, len(MODELS) + 1)
        ]
        self.heading = heading_filter(heading, covariance[2, 2], config)

    @property
    def velocity(self) -> Floats:
        """(M, 2) by each model [m/s]; the stationary one has none."""
        return np.array([kf.x[2:4] if kf.dim_x > 2 else (0.0, 0.0) for kf in self.models])

    def predict(self, step: Motion) -> None:
        """Move all filters on by one time step."""
        for kf, (transition, noise) in zip(self.models, step.models, strict=True):
            kf.predict(F=transition, Q=noise)
        transition, noise = step.heading
        self.heading.predict(F=transition, Q=noise)

    def log_likelihood(self, residual: Floats, covariance: Floats) -> Floats:
        """(M,) logarithm of (11) for pre-fit residuals (M, 2) [m] of a measurement with covariance (2, 2).

        The paper prints S = H P H' in (10), which leaves out the measurement's own noise; S = H P H' + R here.
        """
        spread = np.stack([kf.P[:2, :2] for kf in self.models]) + covariance
        distance, determinant = mahalanobis(residual, spread)
        return np.asarray(-0.5 * (distance + np.log((2 * np.pi) ** 2 * determinant)))

    def update(self, residual: Floats, covariance: Floats) -> None:
        """Correct every position filter by its pre-fit residual (M, 2) [m] of a measurement of covariance (2, 2)."""
        for kf, off in zip(self.models, residual, strict=True):
            kf.update(kf.x[:2] + off, R=covariance)

    def shift(self, offset: Floats) -> None:
        """Move the tracked point by `offset` (2,) [m]: another corner of the same vehicle."""
        for kf in self.models:
            kf.x[:2] += offset

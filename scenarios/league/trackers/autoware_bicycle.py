"""Autoware's vehicle tracker: its rule for rectangles, and an extended Kalman filter of a two-axle (bicycle) state.

State: x, y of the centre [m], yaw [rad], speed along the velocity [m/s], slip angle at the centre [rad]. With the
distance l from the centre to the rear axle, and the rear wheels rolling without slip,

    x' = v cos(yaw + slip),  y' = v sin(yaw + slip),  yaw' = v / l sin(slip)

(Rajamani 2012, Vehicle Dynamics and Control, section 2.2). The noise is white in acceleration and in slip rate.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from luxloop.scenarios.league.trackers.track_book import MakeDetector, Readings, TrackBook, VehicleBoxes
from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.detection.baselines import autoware
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.detection.rectangles import measure
from luxloop.tracker.geometry import fold, wrap
from luxloop.tracker.records import Candidates, Linkage, SegmentedPoints, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

POINTS_MAX = 400
"""Largest number of points of a fit, evenly chosen."""


class AutowareDetector(Detector):
    """The shipped detector with another fit."""

    def fit(self, points: SegmentedPoints, linkage: Linkage) -> Candidates:
        """Fit one rectangle to every segment; its sides are measured on the points on lines, as for all methods."""
        count = points.segments.count
        parts = np.split(points.xy, points.offset[1:-1]) if count else []
        angles = [autoware(part[_even(len(part))]) for part in parts]
        heading = fold(np.reshape(angles, (-1, 1)).astype(np.float64))
        center, size = measure(points, linkage, heading, self.config.lidar.range_std_m)
        best = np.zeros(count, dtype=np.int64)
        return Candidates(heading, center, size, np.zeros_like(heading), best)


def _even(count: int) -> Ints:
    """Return the indices of at most `POINTS_MAX` of `count` points."""
    kept = min(count, POINTS_MAX)
    return np.arange(kept) * count // max(kept, 1)


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


BEYOND = 1e3
"""Cost of a pair outside the gate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BicycleSettings:
    """Settings of filter, gate and book."""

    acceleration_std: float = 4.0
    """[m/s^2]."""
    slip_rate_std: float = 0.3
    """[rad/s]."""
    position_std_m: float = 0.4
    heading_std_rad: float = 0.15
    gate_sigma: float = 4.0
    """Largest distance of a measured centre to its prediction [standard deviations]."""
    confirm_hits: int = 4
    coast_s: float = 1.0


class AutowareBicycle:
    """Hungarian assignment of rectangles to vehicles by the Mahalanobis distance of their centres."""

    def __init__(self, config: TrackerConfig, make_detector: MakeDetector = AutowareDetector, **settings: Any) -> None:
        own = self._settings = BicycleSettings(**settings)
        self._boxes = VehicleBoxes(config, make_detector)
        self._book = TrackBook(own.confirm_hits, own.coast_s)
        self._noise = np.array([own.position_std_m, own.position_std_m, own.heading_std_rad])
        self._filters: dict[int, BicycleFilter] = {}
        self._lengths: dict[int, float] = {}
        self._time: float | None = None
        self._started = 0

    def step(self, scan: Scan) -> Tracks:
        """Return the tracks of a scan."""
        own, readings = self._settings, self._boxes.step(scan)
        dt = 0.0 if self._time is None else scan.time - self._time
        self._time = scan.time
        for key, each in self._filters.items():
            each.predict(dt, self._lengths[key], own.acceleration_std, own.slip_rate_std)
        pairs = self._pairs(readings)
        for key, b in pairs.items():
            self._filters[key].update(readings.center[b], float(readings.heading[b]), self._noise)
            self._book.see(key, readings, b, scan.time, self._filters[key].velocity)
            self._lengths[key] = float(readings.size[b, 0])
        for key in [key for key in self._filters if self._book.ends(key, scan.time)]:
            del self._filters[key], self._lengths[key]
        for b in sorted(set(range(len(readings.center))) - set(pairs.values())):
            self._start(readings, b, scan)
        keys = [*self._filters]
        at, speed = [self._filters[k].mean[:2] for k in keys], [self._filters[k].velocity for k in keys]
        return self._book.report([*keys], at, speed, scan.time)

    def _start(self, readings: Readings, b: int, scan: Scan) -> None:
        key, self._started = self._started, self._started + 1
        self._filters[key] = BicycleFilter.start(readings.center[b], float(readings.heading[b]), self._noise)
        self._lengths[key] = float(readings.size[b, 0])
        self._book.start(key, readings, b, scan.time, float(scan.ego_pose_odom[2]))

    def _pairs(self, readings: Readings) -> dict[int, int]:
        """Return the box of each track that has one."""
        keys = [*self._filters]
        distances = [[self._filters[k].distance(c, self._noise) for c in readings.center] for k in keys]
        cost: Floats = np.reshape(np.array(distances, dtype=np.float64), (len(keys), len(readings.center)))
        cost = np.where(cost <= self._settings.gate_sigma, cost, BEYOND)
        pairs = zip(*linear_sum_assignment(cost), strict=True)
        return {keys[t]: int(b) for t, b in pairs if cost[t, b] < BEYOND}

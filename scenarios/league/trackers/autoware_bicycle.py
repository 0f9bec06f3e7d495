"""Autoware's rule for rectangles, and an extended Kalman filter of a two-axle state."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from luxloop.arrays import Floats
from luxloop.scenarios.league.trackers.autoware_fits import AutowareDetector
from luxloop.scenarios.league.trackers.bicycle_filter import BicycleFilter
from luxloop.scenarios.league.trackers.track_book import TrackBook
from luxloop.scenarios.league.trackers.vehicle_boxes import MakeDetector, Readings, VehicleBoxes
from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

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

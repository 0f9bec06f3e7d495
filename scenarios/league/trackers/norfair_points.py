"""norfair-enough: nearest neighbours by Euclidean distance, with a constant-velocity Kalman filter per frame."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from luxloop.scenarios.league.trackers.track_book import TrackBook
from luxloop.scenarios.league.trackers.vehicle_boxes import MakeDetector, VehicleBoxes
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class NorfairSettings:
    """Arguments of `norfair.Tracker` and of its filter."""

    distance_m: float = 2.5
    confirm_hits: int = 4
    coast_s: float = 1.0
    frame_s: float = 0.08
    """Time between two scans of the shipped rig [s]: norfair counts frames."""
    measurement_variance: float = 0.15
    """[m^2]."""
    process_variance: float = 0.02
    """Noise of position and of velocity per frame."""


class NorfairPoints:
    """Tracks of `norfair.Tracker` on the centres of vehicles."""

    def __init__(self, config: TrackerConfig, make_detector: MakeDetector = Detector, **settings: Any) -> None:
        from norfair import OptimizedKalmanFilterFactory
        from norfair import Tracker as Norfair

        own = self._settings = NorfairSettings(**settings)
        self._boxes = VehicleBoxes(config, make_detector)
        self._book = TrackBook(confirm_hits=1, coast_s=np.inf)  # norfair confirms and ends tracks
        frames = max(round(own.coast_s / own.frame_s), own.confirm_hits + 1)
        self._norfair = Norfair(
            distance_function="euclidean",
            distance_threshold=own.distance_m,
            hit_counter_max=frames,
            initialization_delay=own.confirm_hits - 1,
            filter_factory=OptimizedKalmanFilterFactory(R=own.measurement_variance, Q=own.process_variance),
        )
        self._known = set[int | None]()

    def step(self, scan: Scan) -> Tracks:
        """Return the tracks of a scan."""
        from norfair import Detection

        readings = self._boxes.step(scan)
        centers = readings.center
        active = self._norfair.update([Detection(c[None], data=(scan.time, b)) for b, c in enumerate(centers)])
        keys, at, speed = [], [], []
        for track in active:
            time_s, b = track.last_detection.data
            velocity = np.asarray(track.estimate_velocity, dtype=np.float64)[0] / self._settings.frame_s
            if time_s == scan.time and track.id in self._known:
                self._book.see(track.id, readings, b, scan.time, velocity)
            elif time_s == scan.time:
                self._known.add(track.id)
                self._book.start(track.id, readings, b, scan.time, float(scan.ego_pose_odom[2]))
            if track.id in self._known:
                keys.append(track.id)
                at.append(np.asarray(track.estimate, dtype=np.float64)[0])
                speed.append(velocity)
        return self._book.report(keys, at, speed, scan.time)

"""Frame of the trackers of Stone Soup: constant velocity, linear measurements of the centre of a vehicle.

Stone Soup's own tracker classes keep tracks and detections in sets, whose order changes from process to process.
This loop passes lists, so that equal scans give equal tracks.
"""

from abc import ABC, abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, ClassVar, NamedTuple

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.league.trackers.track_book import TrackBook
from luxloop.scenarios.league.trackers.vehicle_boxes import MakeDetector, VehicleBoxes
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

EPOCH = datetime(2000, 1, 1)
SPEED_STD_MPS = 10.0
"""Standard deviation of the velocity of a new track, per axis [m/s]."""
POSITIONS, VELOCITIES = [0, 2], [1, 3]
"""Places in the state x, vx, y, vy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings that all trackers of Stone Soup have."""

    acceleration: float = 5.0
    """Spectral density of the white acceleration [m^2/s^3]."""
    position_std_m: float = 0.4
    """Standard deviation of a measured centre, per axis [m]."""
    gate_sigma: float = 4.0
    """Largest distance of a measurement to its prediction [standard deviations]."""
    confirm_hits: int = 4
    """As for `TrackBook`."""
    coast_s: float = 1.0
    """As for `TrackBook`."""


class Associated(NamedTuple):
    """Boxes by track (an index, or None without a measurement), and boxes that may start tracks."""

    box_of_track: list[int | None]
    free: list[int]


class StoneSoupTracker(ABC):
    """Tracker whose filter and association are Stone Soup's."""

    settings_type: ClassVar[type[Settings]] = Settings

    def __init__(self, config: TrackerConfig, make_detector: MakeDetector = Detector, **settings: Any) -> None:
        from stonesoup.models.measurement.linear import LinearGaussian
        from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity

        self.settings = self.settings_type(**settings)
        self._boxes = VehicleBoxes(config, make_detector)
        self._book = TrackBook(self.settings.confirm_hits, self.settings.coast_s)
        axis = [ConstantVelocity(self.settings.acceleration) for _ in range(2)]
        self.motion = CombinedLinearGaussianTransitionModel(axis, seed=0)
        noise = self.settings.position_std_m**2 * np.eye(2)
        self.measured = LinearGaussian(ndim_state=4, mapping=POSITIONS, noise_covar=noise)
        self._tracks: list[Any] = []

    @abstractmethod
    def associate(self, tracks: list[Any], detections: list[Any], now: datetime) -> Associated:
        """Append the new state to each track, and return which measurement it has."""

    def first_state(self, center: Floats, now: datetime) -> Any:
        """Return the state of a new track at `center` (2,)."""
        from stonesoup.types.state import GaussianState

        variance = np.diag([self.settings.position_std_m**2, SPEED_STD_MPS**2] * 2)
        return GaussianState([[center[0]], [0.0], [center[1]], [0.0]], variance, timestamp=now)

    def mean(self, track: Any) -> Floats:
        """Return the reported state (4,) of a track."""
        return np.asarray(track.state.mean, dtype=np.float64).reshape(-1)

    def step(self, scan: Scan) -> Tracks:
        """Return the tracks of a scan."""
        from stonesoup.types.detection import Detection
        from stonesoup.types.track import Track

        readings, now = self._boxes.step(scan), EPOCH + timedelta(seconds=scan.time)
        detections = [Detection(c[:, None], timestamp=now, measurement_model=self.measured) for c in readings.center]
        found = self.associate(self._tracks, detections, now)
        for track, b in zip(self._tracks, found.box_of_track, strict=True):
            if b is not None:
                self._book.see(track.id, readings, b, scan.time, self.mean(track)[VELOCITIES])
        self._tracks = [track for track in self._tracks if not self._book.ends(track.id, scan.time)]
        for b in found.free:
            self._tracks.append(Track([self.first_state(readings.center[b], now)]))
            self._book.start(self._tracks[-1].id, readings, b, scan.time, float(scan.ego_pose_odom[2]))
        keys: list[Hashable] = [track.id for track in self._tracks]
        at, speed = ([self.mean(track)[part] for track in self._tracks] for part in (POSITIONS, VELOCITIES))
        return self._book.report(keys, at, speed, scan.time)

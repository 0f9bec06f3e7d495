"""The ideal causal tracker: the best tracks that the scans of a run allow.

It knows the pose of every vehicle that the grader grades in a frame, which has enough points, and nothing of others.

A track starts at the second frame with enough points. It keeps its id through any gap that `grading.memory_s` allows;
after a longer one the vehicle is a new one. Nothing is reported in frames with fewer points, which are not graded.

An end of a vehicle is known once a point on its body was within `END_MARGIN_M` of it, in this frame or before, since
the vehicle's track began. A side with two known ends is true. With one known end, the side extends from that end over
the usual length of the class, or over all that was seen if that is more; with none, it is centred on what was seen.

Errors of the poses are normal, independent of frame and vehicle: of the heading, and of the centre along either axis.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.grading import body_points
from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.plane_geometry import out_of_frame, turned
from luxloop.scenarios.oracle.oracle_detector import visible
from luxloop.scenarios.oracle.stage import ORACLE
from luxloop.scenarios.run import device
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.scripted.script import SIZE_BY_KIND
from luxloop.sim.world import Kind, WorldFrame
from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

USUAL_SIZE_M = np.array([SIZE_BY_KIND[kind][:2] for kind in Kind])
"""(kinds, 2) usual length and width by `Kind` [m]."""
FIRST_REPORT = 2
"""Frame with enough points in which a track starts."""


@dataclass(frozen=True, slots=True)
class PoseNoise:
    """Standard deviations of the poses of an ideal tracker."""

    heading_deg: float = 1.0
    """[deg]."""
    position_m: float = 0.05
    """Of the centre, along either axis [m]."""


@dataclass(slots=True, eq=False)
class Sighted:
    """Known extent of a vehicle since its track began."""

    track_id: int
    seen_s: float
    """Time of the last frame with enough points [s]."""
    frames: int = 0
    """Frames with enough points."""
    low: Floats = field(default_factory=lambda: np.full(2, np.inf))
    """(2,) lowest place seen along and across, from the centre [m]; the true end once it is known."""
    high: Floats = field(default_factory=lambda: np.full(2, -np.inf))
    """(2,) highest place."""

    def extend(self, low: Floats, high: Floats) -> None:
        """Add the places (2,) that a frame shows."""
        self.low, self.high = np.minimum(self.low, low), np.maximum(self.high, high)


class CeilingTracker:
    """An ideal causal tracker. It receives the truth before each scan, as a registered oracle.

    Parameters
    ----------
    grading
        Limits by which the grader decides which vehicles have enough points.
    ranging
        Beam origins of the rig.
    noise
        Errors of the poses.
    seed
        Seed of these errors.
    """

    def __init__(self, grading: GradingConfig, ranging: Ranging, noise: PoseNoise, seed: int) -> None:
        self._grading = grading
        self._ranging = ranging
        self._noise = noise
        self._random = np.random.default_rng(seed)
        self._sighted: dict[int, Sighted] = {}
        self._next_id = 0

    def see_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Set the ground truth of the next scan."""
        self._frame, self._truth = frame, truth

    def step(self, scan: Scan) -> Tracks:
        """Return the tracks of one scan."""
        frame_truth = FrameTruth.of(self._frame, scan, self._truth, self._grading)
        rows = np.flatnonzero(frame_truth.graded)
        vehicles = [self._sight(id, scan.time) for id in frame_truth.actors.id[rows].tolist()]
        self._extend(frame_truth, rows, vehicles)
        reported = np.array([vehicle.frames >= FIRST_REPORT for vehicle in vehicles], np.bool_)
        known = [vehicle for vehicle, shown in zip(vehicles, reported, strict=True) if shown]
        return self._tracks(frame_truth, rows[reported], known)

    def _sight(self, actor_id: int, time_s: float) -> Sighted:
        """Return what is known of a vehicle with enough points in this frame."""
        vehicle = self._sighted.get(actor_id)
        if vehicle is None or time_s - vehicle.seen_s > self._grading.memory_s:
            vehicle = self._sighted[actor_id] = Sighted(self._next_id, time_s)
            self._next_id += 1
        vehicle.seen_s = time_s
        vehicle.frames += 1
        return vehicle

    def _extend(self, frame_truth: FrameTruth, rows: Ints, vehicles: list[Sighted]) -> None:
        """Add the points of this frame to what is known of vehicles in `rows` (K,)."""
        whole_scan = np.zeros(len(frame_truth.scan.points_ego), np.int64)  # one segment of all points
        points = body_points.of_observations(frame_truth, self._ranging, whole_scan, rows, np.zeros_like(rows))
        place = np.column_stack([points.position.real, points.position.imag])
        shown, row = np.unique(points.observation, return_inverse=True)
        size = frame_truth.actors.size[rows[shown], :2].astype(np.float64)
        for k, low, high in zip(shown.tolist(), *visible(place, row, size), strict=True):
            vehicles[k].extend(low, high)

    def _tracks(self, frame_truth: FrameTruth, rows: Ints, vehicles: list[Sighted]) -> Tracks:
        actors = frame_truth.actors
        true_size, usual = actors.size[rows, :2].astype(np.float64), USUAL_SIZE_M[actors.kind[rows]]
        low, high = (np.array([getattr(one, end) for one in vehicles]).reshape(-1, 2) for end in ("low", "high"))
        low, high = assumed_ends(low, high, true_size, usual)
        pose = out_of_frame(frame_truth.boxes_ego[rows, :3], frame_truth.scan.ego_pose_odom)
        center = pose[:, :2] + turned(0.5 * (low + high), pose[:, 2])
        error = self._random.standard_normal((len(rows), 3))
        return Tracks.from_boxes(
            [vehicle.track_id for vehicle in vehicles],
            center + self._noise.position_m * error[:, :2],
            pose[:, 2] + math.radians(self._noise.heading_deg) * error[:, 2],
            high - low,
        )


device.ORACLES.add(CeilingTracker)


def assumed_ends(low: Floats, high: Floats, size: Floats, usual: Floats) -> tuple[Floats, Floats]:
    """Return the low and high ends (K, 2) of vehicles that an ideal tracker assumes, from the true centre [m].

    Parameters
    ----------
    low, high
        (K, 2) places seen; equal to the true end where it is known. Infinite for vehicles without a clean point.
    size, usual
        (K, 2) true sizes, and those of the classes.
    """
    unseen = ~(high >= low)
    low, high = np.where(unseen, 0.0, low), np.where(unseen, 0.0, high)
    low_known, high_known = low <= -0.5 * size, high >= 0.5 * size
    missing = np.where(low_known & high_known, 0.0, np.maximum(usual - (high - low), 0.0))
    at_low = np.where(low_known, 0.0, np.where(high_known, 1.0, 0.5))
    return low - at_low * missing, high + (1.0 - at_low) * missing


@dataclass(frozen=True, slots=True)
class CeilingFactory:
    """Factory of ideal causal trackers; a `luxloop.scenarios.run.device.DeviceFactory`."""

    grading: GradingConfig
    ranging: Ranging
    noise: PoseNoise
    seed: int

    def __call__(self, _config: TrackerConfig) -> CeilingTracker:
        """Return a new tracker."""
        return CeilingTracker(self.grading, self.ranging, self.noise, self.seed)

    def __str__(self) -> str:
        return f"{ORACLE}ceiling, {self.noise.heading_deg:g} deg, {self.noise.position_m:g} m"

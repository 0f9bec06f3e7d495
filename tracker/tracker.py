"""The tracker of the paper: scans in, tracks out. `Tracker.step` follows its block diagram."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from luxloop.arrays import Ints
from luxloop.tracker.detection.boxes import small_boxes
from luxloop.tracker.detection.detector import CLOCK_DIGITS, BoxDetector, Detector, DetectorConfig
from luxloop.tracker.merging import MergeConfig
from luxloop.tracker.occupancy import Occupancy
from luxloop.tracker.records import NO_TRACK, Detection, OrientedBoxes, StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracking.association import AssociationConfig, Associator, HungarianAssociator
from luxloop.tracker.tracking.confirmation import ConfirmationConfig
from luxloop.tracker.tracking.corner import CornerConfig
from luxloop.tracker.tracking.correction import correct
from luxloop.tracker.tracking.existence import ExistenceConfig, terminate_lost
from luxloop.tracker.tracking.filters import FilterConfig, motion
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, Predictions, hypothesise
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.model_selection import ModelSelection
from luxloop.tracker.tracking.model_selection import model_selection as select_models
from luxloop.tracker.tracking.motion_evidence import MotionEvidence
from luxloop.tracker.tracking.observations import observe
from luxloop.tracker.tracking.output import report
from luxloop.tracker.tracking.prediction import predict
from luxloop.tracker.tracking.small_objects import SmallObjects
from luxloop.tracker.tracking.small_tracks import LENGTH_MAX_M, WIDTH_MAX_M, SmallConfig
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_management import DefaultTrackManagement, TrackManagement
from luxloop.tracker.tracking.track_observation import assigned
from luxloop.tracker.tracking.track_table import TENTATIVE, TrackTable, empty


@dataclass(frozen=True, slots=True)
class TrackerConfig(DetectorConfig):
    """Settings of the tracker, one section per stage: the sections of detection, then those of tracking."""

    hypotheses: HypothesisConfig = field(default_factory=HypothesisConfig)
    association: AssociationConfig = field(default_factory=AssociationConfig)
    filters: FilterConfig = field(default_factory=FilterConfig)
    mma: MmaConfig = field(default_factory=MmaConfig)
    merging: MergeConfig = field(default_factory=MergeConfig)
    corner: CornerConfig = field(default_factory=CornerConfig)
    confirmation: ConfirmationConfig = field(default_factory=ConfirmationConfig)
    existence: ExistenceConfig = field(default_factory=ExistenceConfig)
    small: SmallConfig = field(default_factory=SmallConfig)

    def __post_init__(self) -> None:
        if self.mma.method == "imm" and len(self.filters.models) < 2:
            raise ValueError(
                f'mma.method is "imm" and filters.models is {list(self.filters.models)}: an interacting multiple model '
                "needs two models or more; add one, or use another method"
            )


def track_config(config: TrackerConfig) -> TrackConfig:
    """Return the sections that one track uses."""
    return TrackConfig(config.filters, config.corner, config.confirmation, config.existence)


class TrackerStages(NamedTuple):
    """Stages of a tracker, as `Tracker` receives them."""

    detector: BoxDetector
    associator: Associator
    model_selection: ModelSelection
    track_management: TrackManagement


class Tracker:
    """Tracks the vehicles around the ego through a sequence of scans.

    Parameters
    ----------
    config
        Settings of all stages.
    detector
        Finds boxes in a scan; default `Detector`.
    associator
        Assigns boxes to tracks; default `HungarianAssociator`.
    model_selection
        Mixes, corrects and selects the motion models of tracks; default by `mma.method`.
    track_management
        Starts, merges and terminates tracks; default `DefaultTrackManagement`.
    """

    def __init__(
        self,
        config: TrackerConfig | None = None,
        detector: BoxDetector | None = None,
        *,
        associator: Associator | None = None,
        model_selection: ModelSelection | None = None,
        track_management: TrackManagement | None = None,
    ) -> None:
        self.config = config = config or TrackerConfig()
        self._detector = detector or Detector(config)
        self._associator = associator or HungarianAssociator(config.association)
        self._selection = model_selection or select_models(config.mma)
        self._settings = track_config(config)
        self._management = track_management or DefaultTrackManagement(config.merging, self._settings)
        self._motion = MotionEvidence()
        self._small = SmallObjects()
        self._tracks = empty(config.filters.models)
        self._time: float | None = None

    @property
    def stages(self) -> TrackerStages:
        """Stages; oracles set others before the first scan."""
        return TrackerStages(self._detector, self._associator, self._selection, self._management)

    @stages.setter
    def stages(self, stages: TrackerStages) -> None:
        self._detector, self._associator, self._selection, self._management = stages

    def step(self, scan: Scan) -> tuple[Tracks, StepTrace]:
        """Process one scan; return the living and the just terminated tracks, and all intermediate results.

        A scan without points, or whose points form no vehicle (a single point, or all at one place), updates no track:
        tracks coast. Collinear points are a side of a vehicle. A point with a non-finite position or time is ignored.
        After a gap between scans, tracks that probably do not exist any more (`ExistenceConfig`) are terminated; the
        others continue at their predicted positions.

        Raises
        ------
        ValueError
            The time or the ego pose is not finite, a field has a wrong shape or type, or the scan is not later than
            the one before. The caller decides between a late scan, to be dropped, and the start of another recording,
            which needs a new tracker. The tracker is unchanged and accepts the next scan.
        """
        self._detector.check(scan)
        dt, config = self._elapsed(scan.time), self.config
        tracks = self._tracks.subset(self._tracks.alive)
        predict(tracks, motion(dt, config.filters), self._selection, self._settings)
        living = tracks.subset(tracks.alive)
        detection = self._detector.step(scan, living.boxes(living.size), long_vehicles(living))
        observations = observe(detection.boxes, scan.ego_pose_odom, config.filters)
        predictions = Predictions.of(tracks)
        hypotheses = hypothesise(predictions, observations, config.hypotheses)
        pairs = self._associator.associate(tracks, predictions, hypotheses, observations)
        observed = assigned(hypotheses, observations, pairs)
        correct(tracks, observed, self._selection, self._settings, dt)
        self._motion.observe(tracks, observed, Occupancy.of(scan))
        terminate_lost(tracks, scan, config.existence)
        track_id = box_ids(tracks, pairs, len(observations))
        self._tracks = self._management.manage(tracks, observations, track_id, scan.ego_pose_odom, self._selection)
        output = self._add_small(report(self._tracks, self._selection), detection, scan, dt)
        return output, StepTrace(detection.segments, detection.linkage, detection.candidates, detection.boxes, track_id)

    def _elapsed(self, time: float) -> float:
        """Return the time since the last scan, 0 for the first [s]."""
        dt = 0.0 if self._time is None else round(time - self._time, CLOCK_DIGITS)
        self._time = time
        return dt

    def _add_small(self, output: Tracks, detection: Detection, scan: Scan, dt: float) -> Tracks:
        """Track the small road users, and add them to the record of the vehicles."""
        if not self.config.small.enabled:
            return output
        boxes = small_boxes(detection, scan, LENGTH_MAX_M, WIDTH_MAX_M)
        self._small.step(boxes, self._tracks, dt)
        return self._small.report(self._tracks, output, scan.ego_pose_odom[:2])


def long_vehicles(tracks: TrackTable) -> OrientedBoxes:
    """Return the visible parts of the confirmed or coasting vehicles that are longer than a car."""
    long = tracks.subset((tracks.status != TENTATIVE) & tracks.long)
    return long.boxes(long.visible_size)


def box_ids(tracks: TrackTable, pairs: Sequence[tuple[int, int]], boxes: int) -> Ints:
    """(B,) id of the track that each of the `boxes` was assigned to by pairs (track, box), `NO_TRACK` for none."""
    track_id = np.full(boxes, NO_TRACK, dtype=np.int64)
    for t, b in pairs:
        track_id[b] = tracks.id[t]
    return track_id

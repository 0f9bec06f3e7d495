"""A tracker with oracles in place of stages."""

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass

from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.oracle.oracle_detector import OracleDetector
from luxloop.scenarios.oracle.oracle_tracks import (
    ActorRecorder,
    OracleConfirmation,
    OracleModelSelection,
    OracleScore,
    OracleSizes,
    OracleTrackManagement,
)
from luxloop.scenarios.oracle.oracle_truth import OracleContext, Truth
from luxloop.scenarios.oracle.stage import ORACLE, Stage
from luxloop.scenarios.run import device
from luxloop.scenarios.run.device import APART, DeviceFactory
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig, TrackerStages
from luxloop.tracker.tracking.association import HungarianAssociator
from luxloop.tracker.tracking.track_management import DefaultTrackManagement, TrackManagement


class OracleTracker:
    """A tracker that gets the ground truth before each scan. Stages without an oracle are its own.

    Parameters
    ----------
    tracker
        A new tracker with stages as `REPLACEABLE` lists them.
    stages
        Stages to replace by oracles.

    Raises
    ------
    DeviceError
        The settings have no such stage.
    """

    def __init__(self, tracker: Tracker, stages: Iterable[Stage]) -> None:
        replaced = frozenset(stages)
        if Stage.MODEL in replaced and tracker.config.mma.method == "imm":
            raise DeviceError(
                'oracle model: [tracker.mma] method = "imm" selects no model that the truth could; use "mma" or "paper"'
            )
        self._context = OracleContext()
        tracker.stages = _with_truth(tracker, replaced, self._context)
        self._tracker = tracker

    def see_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Set the ground truth of the next scan."""
        self._context.truth = Truth.of(frame, truth)

    def step(self, scan: Scan) -> tuple[Tracks, StepTrace]:
        """Process one scan, see `Tracker.step`."""
        return self._tracker.step(scan)


device.ORACLES.add(OracleTracker)


def _with_truth(tracker: Tracker, replaced: frozenset[Stage], context: OracleContext) -> TrackerStages:
    """Return the stages of a tracker with the truth in place of some."""
    detector, associator, models, management = tracker.stages
    assert isinstance(detector, Detector)  # as `OracleFactory` requires
    assert isinstance(associator, HungarianAssociator)
    assert isinstance(management, DefaultTrackManagement)
    confirming = OracleConfirmation.over(management, replaced, context)
    deciding: TrackManagement = confirming
    if Stage.ASSOCIATION in replaced:
        associator, deciding = copy(associator), OracleTrackManagement(confirming, context)
        associator.score = OracleScore(associator.score, context)
    if Stage.MODEL in replaced:
        models = OracleModelSelection(tracker.config.mma, context)
    recording = (OracleSizes if Stage.SIZE in replaced else ActorRecorder)(deciding, context)
    seeing = OracleDetector.over(detector, replaced, context)
    return TrackerStages(seeing, associator, models, recording)


REPLACEABLE: dict[str, tuple[type, str]] = {
    "detector": (Detector, "segment, link, fit and box"),
    "associator": (HungarianAssociator, "pair score"),
    "track_management": (DefaultTrackManagement, "settle, merge, newcomers and start"),
}
"""Stages in which oracles replace parts, by their names in `TrackerStages`: class that has these, and the parts."""


def _place(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


@dataclass(frozen=True, slots=True)
class OracleFactory:
    """Factory of trackers with oracles for these stages; a `luxloop.scenarios.run.device.DeviceFactory`."""

    stages: Sequence[Stage]
    make_tracker: DeviceFactory = Tracker
    """Makes the tracker; the shipped one by default."""

    def __call__(self, config: TrackerConfig) -> OracleTracker:
        """Return a new tracker.

        Raises
        ------
        DeviceError
            The tracker or its settings have no such stage.
        """
        name = device.name_of(self.make_tracker)
        if isinstance(self.make_tracker, APART):
            raise DeviceError(f"{name}: oracles cannot replace the stages of another process")
        tracker = self.make_tracker(config)
        if not isinstance(tracker, Tracker):
            raise DeviceError(
                f"{name}: has none of the stages {', '.join(REPLACEABLE)} that oracles replace; "
                f"return a {_place(Tracker)} with stages of its own"
            )
        for stage, (kind, parts) in REPLACEABLE.items():
            if not isinstance(getattr(tracker.stages, stage), kind):
                raise DeviceError(
                    f"{name}: its {stage} has no {parts}, which oracles replace; derive it from {_place(kind)}"
                )
        return OracleTracker(tracker, self.stages)

    def __str__(self) -> str:
        return f"{ORACLE}{', '.join(stage for stage in Stage if stage in self.stages)}"


def choose(tracker: str | DeviceFactory | None, stages: Sequence[Stage], in_process: bool = False) -> DeviceFactory:
    """Return the factory of the device under test: a tracker, or the shipped one with oracles for some stages.

    Raises
    ------
    DeviceError
        Oracles are combined with another tracker than the shipped one, or the tracker cannot be loaded.
    """
    if not stages:
        return device.factory_of(tracker, in_process)
    if tracker not in (None, device.SHIPPED):
        asked, tracker = ", ".join(stages), tracker if isinstance(tracker, str) else device.name_of(tracker)
        raise DeviceError(
            f"--oracle {asked}: oracles replace stages of the shipped tracker, not of {tracker}; "
            "omit --oracle or --tracker"
        )
    return OracleFactory(stages)

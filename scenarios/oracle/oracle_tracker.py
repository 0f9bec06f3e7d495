"""The shipped tracker with oracles in place of stages."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.oracle.oracle_detector import OracleDetector
from luxloop.scenarios.oracle.oracle_tracks import (
    ActorRecorder,
    OracleConfirmation,
    OracleModelSelection,
    OracleScore,
    OracleTrackManagement,
)
from luxloop.scenarios.oracle.oracle_truth import OracleContext, Truth
from luxloop.scenarios.oracle.stage import Stage
from luxloop.scenarios.run import device
from luxloop.scenarios.run.device import DeviceFactory
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig, track_config
from luxloop.tracker.tracking.association import HungarianAssociator, LikelihoodScore, PairScore
from luxloop.tracker.tracking.model_selection import ModelSelection, model_selection
from luxloop.tracker.tracking.track_management import TrackManagement


class OracleTracker:
    """A tracker that gets the ground truth before each scan. Stages without an oracle are those of the shipped tracker.

    Parameters
    ----------
    config
        Settings of all stages.
    stages
        Stages to replace by oracles.
    detector, score, models, confirmation
        Other detector, pair score, model selection and track management than the shipped ones, beneath the oracles.

    Raises
    ------
    DeviceError
        The settings have no such stage.
    """

    def __init__(
        self,
        config: TrackerConfig,
        stages: Iterable[Stage],
        detector: type[OracleDetector] = OracleDetector,
        score: PairScore | None = None,
        models: ModelSelection | None = None,
        confirmation: type[OracleConfirmation] = OracleConfirmation,
    ) -> None:
        replaced = frozenset(stages)
        if Stage.MODEL in replaced and config.mma.method == "imm":
            raise DeviceError(
                'oracle model: [tracker.mma] method = "imm" selects no model that the truth could; use "mma" or "paper"'
            )
        self._context = context = OracleContext()
        score = score or LikelihoodScore(config.association)
        models = models or model_selection(config.mma)
        management: TrackManagement
        management = shipped = confirmation(config.merging, track_config(config), replaced, context)
        if Stage.ASSOCIATION in replaced:
            score, management = OracleScore(score, context), OracleTrackManagement(shipped, context)
        if Stage.MODEL in replaced:
            models = OracleModelSelection(config.mma, context)
        self._tracker = Tracker(
            config,
            detector(config, replaced, context),
            associator=HungarianAssociator(config.association, score),
            model_selection=models,
            track_management=ActorRecorder(management, context),
        )

    def see_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Set the ground truth of the next scan."""
        self._context.truth = Truth.of(frame, truth)

    def step(self, scan: Scan) -> tuple[Tracks, StepTrace]:
        """Process one scan, see `Tracker.step`."""
        return self._tracker.step(scan)


@dataclass(frozen=True, slots=True)
class OracleFactory:
    """Factory of trackers with oracles for these stages; a `luxloop.scenarios.run.device.DeviceFactory`."""

    stages: Sequence[Stage]

    def __call__(self, config: TrackerConfig) -> OracleTracker:
        """Return a new tracker.

        Raises
        ------
        DeviceError
            The settings have no such stage.
        """
        return OracleTracker(config, self.stages)

    def __str__(self) -> str:
        return f"oracle: {', '.join(stage for stage in Stage if stage in self.stages)}"


def choose(tracker: str | DeviceFactory | None, stages: Sequence[Stage]) -> DeviceFactory:
    """Return the factory of the device under test: a tracker, or the shipped one with oracles for some stages.

    Raises
    ------
    DeviceError
        Oracles are combined with another tracker than the shipped one, or the tracker cannot be loaded.
    """
    if not stages:
        return device.factory_of(tracker)
    if tracker not in (None, device.SHIPPED):
        asked, tracker = ", ".join(stages), tracker if isinstance(tracker, str) else device.name_of(tracker)
        raise DeviceError(
            f"--oracle {asked}: oracles replace stages of the shipped tracker, not of {tracker}; "
            "omit --oracle or --tracker"
        )
    return OracleFactory(stages)

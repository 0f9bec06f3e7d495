"""The shipped tracker with the truth in the place of stages."""

from collections.abc import Callable, Iterable

import numpy as np

from scenarios.arrays import Bools, Floats, Ints
from scenarios.errors import DeviceError
from scenarios.oracle import oracle_association
from scenarios.oracle.oracle_detector import OracleDetector
from scenarios.oracle.oracle_model import ToldBank
from scenarios.oracle.oracle_truth import Truth
from scenarios.oracle.stage import Stage
from sensor_model.truth import NO_ACTOR, ScanTruth
from sim.world import WorldFrame
from tracker.records import Status
from tracker.tracker import Tracker, TrackerConfig
from tracker.tracking.hypotheses import Hypotheses, Predictions
from tracker.tracking.observations import Observations


class OracleTracker(Tracker):
    """A tracker that is told the truth before each scan; stages that are not replaced are the real ones.

    A track follows the actor that owns the last of its boxes that anyone owns.
    """

    def __init__(
        self, config: TrackerConfig, stages: Iterable[Stage], detector: type[OracleDetector] = OracleDetector
    ) -> None:
        self._stages = frozenset(stages)
        if Stage.MODEL in self._stages and config.mma.method == "imm":
            raise DeviceError(
                'oracle model: [tracker.mma] method = "imm" selects no model that the truth could; use "mma" or "paper"'
            )
        self._fitting = detector(config, self._stages)
        super().__init__(config, self._fitting)
        self._actor_of: dict[int, int] = {}
        """Actor by the id of the track that follows it."""

    def see_truth(self, frame: WorldFrame, truth: ScanTruth) -> None:
        """Take in the truth of the scan that comes next."""
        self._fitting.truth = Truth.of(frame, truth)

    def _predict(self, time: float) -> None:
        super()._predict(time)
        self._tell_modes()

    def _score(self, predictions: Predictions, pairing: Hypotheses, seen: Observations) -> tuple[Floats, Bools]:
        cost, in_gate = super()._score(predictions, pairing, seen)
        if Stage.ASSOCIATION in self._stages:
            told, actor = self._fitting, self._track_actor
            true_center = told.truth.center_odom(actor, told.ego_pose_odom)
            misread = oracle_association.leads_away(predictions, pairing, true_center)
            in_gate = oracle_association.admissible(actor, told.box_actor, in_gate, misread)
        return cost, in_gate

    def _unite(self) -> None:
        if Stage.ASSOCIATION in self._stages:
            self._of_each_actor(super()._unite)
        else:
            super()._unite()

    def _exclude(self) -> None:
        if Stage.ASSOCIATION not in self._stages:
            super()._exclude()
            return
        self._of_each_actor(super()._exclude)
        status = [track.status for track in self._tracks]
        super()._exclude()  # tracks of nobody give way to all others, those of actors have just been decided on
        for track, before, actor in zip(self._tracks, status, self._track_actor.tolist(), strict=True):
            track.status = track.status if actor == NO_ACTOR else before
        self._of_each_actor(lambda: oracle_association.hand_over_id(self._tracks))

    def _of_each_actor(self, decide: Callable[[], None]) -> None:
        """Let something be decided of the tracks of each actor as if there were no others."""
        everyone, actor = self._tracks, self._track_actor
        for one in np.unique(actor[actor != NO_ACTOR]):
            self._tracks = [everyone[t] for t in np.flatnonzero(actor == one)]
            decide()
        self._tracks = everyone

    def _newcomers(self, seen: Observations, track_id: Ints) -> Bools:
        free = super()._newcomers(seen, track_id)
        if Stage.ASSOCIATION not in self._stages:
            return free
        followed = self._track_actor[[track.status is not Status.DEAD for track in self._tracks]]
        return oracle_association.newcomers(self._fitting.box_actor, self._fitting.found.boxes.support, followed, free)

    def _start(self, seen: Observations, track_id: Ints, forward: float) -> None:
        super()._start(seen, track_id, forward)
        owned = (track_id >= 0) & (self._fitting.box_actor != NO_ACTOR)
        self._actor_of.update(zip(track_id[owned].tolist(), self._fitting.box_actor[owned].tolist(), strict=True))
        self._tell_modes()

    @property
    def _track_actor(self) -> Ints:
        """(T,) actor that each track follows, `NO_ACTOR` where none."""
        return np.array([self._actor_of.get(track.id, NO_ACTOR) for track in self._tracks], dtype=np.int64)

    def _tell_modes(self) -> None:
        """Tell every track how its vehicle moves, if that is what the truth is asked for."""
        if Stage.MODEL not in self._stages:
            return
        for track in self._tracks:
            if not isinstance(track.bank, ToldBank):
                track.bank = ToldBank(track.bank.filters, self.config.mma)
            track.bank.tell(self._fitting.truth.mode.get(self._actor_of.get(track.id, NO_ACTOR)))

"""Oracles of the stages on tracks: association, confirmation, the choice of the motion model, and sizes.

Association: a box updates a track of the actor that owns it, regardless of the gate.

A new actor gets a track. Where an actor is seen in pieces, the tracker's own association matches the pieces with the
tracks of that actor, and its own merging makes one track of them. Tracks of different actors are neither merged nor
treated as duplicates. The surviving track of an actor keeps the first id. The coasting time is not part of association
(`[tracker.existence]`): an actor whose tracks were terminated counts as new. Boxes without an actor, such as walls,
are matched with tracks without an actor by the tracker's own association.

The gate also protects from misread boxes: a rear that is taken for a front moves a track by a car's length. The oracle
does the same: it ignores a box outside the gate that would move the track away from its vehicle.

Confirmation: a track on a vehicle is confirmed at once, every other track never.

A track is on the owner of its last box that has one; a new track is on the owner of its first box. Coasting,
termination and the limit on sizes are those of the tracker. A confirmed track keeps the points in its box together:
one that covers two merged vehicles affects later segments.

Model selection: a track selects the model of the true mode of motion of its vehicle.

The other models get a negligible probability, so that mixing starts all filters from the model of the true mode. A
track without an actor selects its model from its observations. The filters, their noise and the times of their
corrections are those of the tracker.

Sizes: a track has the length and width of the vehicle that it follows, from its tracked corner on. Its visible extents
are those of the tracker. A bent truck keeps its estimate.
"""

from collections.abc import Iterator

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.mma_metrics import MODE_OF
from luxloop.scenarios.oracle.oracle_truth import OracleContext, oracle_over
from luxloop.scenarios.oracle.stage import Stage
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import MODELS, Status
from luxloop.tracker.tracking.association import PairScore
from luxloop.tracker.tracking.filters import Step
from luxloop.tracker.tracking.hypotheses import Hypotheses, Predictions
from luxloop.tracker.tracking.mma import LEAST_PROBABILITY, MmaConfig
from luxloop.tracker.tracking.model_selection import ModelSelection, SelectedModel
from luxloop.tracker.tracking.observations import Observations
from luxloop.tracker.tracking.track_management import DefaultTrackManagement, TrackManagement
from luxloop.tracker.tracking.track_table import TrackTable
from luxloop.tracker.tracking.traffic_flow import TrafficFlow
from luxloop.tracker.tracking.vehicle_size import LOG_ODDS_MAX
from luxloop.tracker.vehicle_classes import GRID_M

AWAY_M = 0.5
"""Limit on how far a correct box may move a track away from its vehicle [m]: corners are rounded, sizes are guessed."""


class OracleScore:
    """Cost of the tracker's own association, with a gate by the true owners of boxes; a `PairScore`."""

    def __init__(self, score: PairScore, context: OracleContext) -> None:
        self._score = score
        self._context = context

    def __call__(
        self, tracks: TrackTable, predictions: Predictions, hypotheses: Hypotheses, observations: Observations
    ) -> tuple[Floats, Bools]:
        """Return the cost (T, B) of each pair, and a mask (T, B) of admissible pairs."""
        cost, in_gate = self._score(tracks, predictions, hypotheses, observations)
        context, actor = self._context, self._context.track_actor(tracks)
        true_center = context.truth.center_odom(actor, context.ego_pose_odom)
        misread = leads_away(predictions, hypotheses, true_center)
        return cost, admissible(actor, context.box_actor, in_gate, misread)


class OracleTrackManagement:
    """Track management that knows the actor of each track and box; a `TrackManagement`."""

    def __init__(self, shipped: DefaultTrackManagement, context: OracleContext) -> None:
        self._shipped = shipped
        self._context = context

    def manage(
        self,
        tracks: TrackTable,
        observations: Observations,
        track_id: Ints,
        ego_pose: Floats,
        selection: ModelSelection,
    ) -> TrackTable:
        """Decide on the tracks at the end of a frame, see `TrackManagement.manage`."""
        context, shipped = self._context, self._shipped
        flow = shipped.flow(tracks, ego_pose)
        shipped.orient(tracks, flow)
        shipped.settle(tracks, ego_pose)
        for rows in self._by_actor(tracks):
            shipped.merge(tracks, rows, selection)
        self._remove_duplicates(tracks)
        for rows in self._by_actor(tracks):
            hand_over_id(tracks, rows)
        free = shipped.newcomers(tracks, observations, track_id)
        new = newcomers(context.box_actor, context.support, context.track_actor(tracks)[tracks.alive], free)
        return shipped.start(tracks, new, observations, track_id, flow, selection)

    def _remove_duplicates(self, tracks: TrackTable) -> None:
        """Remove duplicates among the tracks of each actor, and tracks without an actor inside any other."""
        for rows in self._by_actor(tracks):
            self._shipped.remove_duplicates(tracks, rows)
        status = tracks.status.copy()
        self._shipped.remove_duplicates(tracks, np.arange(len(tracks)))
        owned = self._context.track_actor(tracks) != NO_ACTOR
        tracks.status[owned] = status[owned]

    def _by_actor(self, tracks: TrackTable) -> Iterator[Ints]:
        """Yield the rows of the tracks of each actor."""
        track_actor = self._context.track_actor(tracks)
        for actor in np.unique(track_actor[track_actor != NO_ACTOR]):
            yield np.flatnonzero(track_actor == actor)


def admissible(track_actor: Ints, box_actor: Ints, in_gate: Bools, misread: Bools) -> Bools:
    """(T, B) mask of pairs of a track and a box that have the same actor, (T,) and (B,).

    Of the tracks of an actor, those with the box `in_gate` (T, B) are admissible. If there is none, all are that do not
    `misread` (T, B) the box.
    """
    same = track_actor[:, None] == box_actor
    out_of_all_gates = ~(same & in_gate).any(axis=0) & (box_actor != NO_ACTOR)
    return np.asarray(same & (in_gate | (out_of_all_gates & ~misread)))


def leads_away(predictions: Predictions, hypotheses: Hypotheses, true_center: Floats) -> Bools:
    """(T, B) mask of boxes that would move a track away from the true centre (T, 2) of its vehicle, odometry [m]."""
    each, model = np.arange(len(true_center)), predictions.probability.argmax(axis=1)
    error = predictions.selected - predictions.to_corner - true_center
    error_by_box = error[:, None] + hypotheses.innovation[each, :, model]
    return np.asarray(np.linalg.norm(error_by_box, axis=2) > np.linalg.norm(error, axis=1)[:, None] + AWAY_M)


def newcomers(box_actor: Ints, support: Ints, followed: Ints, free: Bools) -> Bools:
    """(B,) mask of boxes that start a track: the largest of each actor not `followed` yet, and those that are `free`.

    Parameters
    ----------
    box_actor
        (B,) actor of each box, `NO_ACTOR` for none.
    support
        (B,) points of each box.
    followed
        Ids of actors that have a track.
    free
        (B,) mask of boxes that start a track by the tracker's own management.
    """
    largest_first = np.argsort(-support, kind="stable")
    _, first = np.unique(box_actor[largest_first], return_index=True)
    largest = np.isin(np.arange(len(box_actor)), largest_first[first])
    return np.asarray(free | (largest & (box_actor != NO_ACTOR) & ~np.isin(box_actor, followed)))


def hand_over_id(tracks: TrackTable, rows: Ints) -> None:
    """Give the oldest id among the tracks `rows` of one actor to its best surviving track."""
    living = rows[tracks.alive[rows]]
    if len(living):
        first, heir = rows[tracks.id[rows].argmin()], living[tracks.hits[living].argmax()]
        if not tracks.alive[first]:
            tracks.id[[first, heir]] = tracks.id[[heir, first]]


class OracleConfirmation(DefaultTrackManagement):
    """A track management with true confirmation, if the stages have it."""

    _active: bool
    _context: OracleContext

    @classmethod
    def over(
        cls, real: DefaultTrackManagement, stages: frozenset[Stage], context: OracleContext
    ) -> "OracleConfirmation":
        """Return a track management with the truth over the decisions of a real one."""
        return oracle_over(cls, DefaultTrackManagement, real, _active=Stage.CONFIRMATION in stages, _context=context)

    def settle(self, tracks: TrackTable, ego_pose: Floats) -> None:
        """Update the status of every track; the truth confirms those that were seen."""
        super().settle(tracks, ego_pose)
        if self._active:
            self._confirm(tracks, np.flatnonzero(tracks.updated), self._context.track_actor(tracks)[tracks.updated])

    def start(
        self,
        tracks: TrackTable,
        newcomers: Bools,
        observations: Observations,
        track_id: Ints,
        flow: TrafficFlow,
        selection: ModelSelection,
    ) -> TrackTable:
        """Start a track for each box of the mask `newcomers` (B,), see `DefaultTrackManagement.start`."""
        joined = super().start(tracks, newcomers, observations, track_id, flow, selection)
        if self._active:
            self._confirm(joined, np.arange(len(tracks), len(joined)), self._context.box_actor[newcomers])
        return joined

    def _confirm(self, tracks: TrackTable, rows: Ints, actor: Ints) -> None:
        """Set the status of the living ones of the tracks `rows` by the actors that they are on, of the same shape."""
        on_vehicle = np.isin(actor, self._context.truth.vehicle_id)
        status = np.where(on_vehicle, Status.CONFIRMED.value, Status.TENTATIVE.value)
        tracks.status[rows] = np.where(tracks.alive[rows], status, tracks.status[rows])


class OracleModelSelection(SelectedModel):
    """Model selection by the true mode of motion of the vehicle that each track follows."""

    def __init__(self, config: MmaConfig, context: OracleContext) -> None:
        super().__init__(config)
        self._context = context

    def predict(self, tracks: TrackTable, step: Step, dt: float) -> None:
        """Move on by one time step and select the true mode at its end."""
        super().predict(tracks, step, dt)
        self.select(tracks)

    def correct(self, tracks: TrackTable, rows: Ints, innovation: Floats, noise: Floats) -> Floats:
        """Correct the filters; the innovations do not change the selected model."""
        used = super().correct(tracks, rows, innovation, noise)
        self.select(tracks)
        return used

    def select(self, tracks: TrackTable) -> None:
        """Select the true modes of the actors; tracks without an actor keep their probabilities."""
        modes = self._context.truth.mode
        for t, actor in enumerate(self._context.track_actor(tracks).tolist()):
            if actor in modes:
                tracks.probability[t] = certain(modes[actor], tracks.models)
        self.summarise(tracks, np.arange(len(tracks)))


class ActorRecorder:
    """Track management that also records which actor each track follows."""

    def __init__(self, management: TrackManagement, context: OracleContext) -> None:
        self._management = management
        self._context = context

    def manage(
        self,
        tracks: TrackTable,
        observations: Observations,
        track_id: Ints,
        ego_pose: Floats,
        selection: ModelSelection,
    ) -> TrackTable:
        """Decide on the tracks at the end of a frame, see `TrackManagement.manage`."""
        managed = self._management.manage(tracks, observations, track_id, ego_pose, selection)
        self._context.add_tracks(track_id)
        if isinstance(selection, OracleModelSelection):
            selection.select(managed)
        return managed


class OracleSizes(ActorRecorder):
    """Recording track management after which every track has the size of the vehicle that it follows."""

    def manage(
        self,
        tracks: TrackTable,
        observations: Observations,
        track_id: Ints,
        ego_pose: Floats,
        selection: ModelSelection,
    ) -> TrackTable:
        """Decide on the tracks at the end of a frame, see `TrackManagement.manage`."""
        managed = super().manage(tracks, observations, track_id, ego_pose, selection)
        size = self._context.truth.size_of(self._context.track_actor(managed))
        for t in np.flatnonzero(np.isfinite(size[:, 0])).tolist():
            managed.size[t], managed.size_std[t] = size[t], SIZE_STD_M
            managed.size_likelihood[t], managed.piece_likelihood[t] = certain_sides(size[t]), 0.0
        return managed


SIZE_STD_M = 0.01
"""Standard deviation of true sides [m]."""


def certain_sides(size: Floats) -> Floats:
    """(2, G) log-likelihoods of known sides (2,) [m], which one view cannot change."""
    likelihood = np.full((2, len(GRID_M)), -LOG_ODDS_MAX)
    likelihood[np.arange(2), np.abs(GRID_M - size[:, None]).argmin(axis=1)] = 0.0
    return likelihood


def certain(mode: int, models: tuple[str, ...] = MODELS) -> Floats:
    """(M,) model probabilities of a known mode, equal for all models of it; above 0 for their logarithms.

    In a bank without a model of the mode all have the same probability.
    """
    describes = np.array([MODE_OF[model] == MODELS[mode] for model in models])
    share = np.where(describes | ~describes.any(), 1.0, LEAST_PROBABILITY)
    return np.asarray(share / share.sum())

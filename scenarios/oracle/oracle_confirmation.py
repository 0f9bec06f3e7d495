"""Oracle for track confirmation: a track on a vehicle is confirmed at once, every other track never.

A track is on the owner of its last box that has one; a new track is on the owner of its first box. Coasting,
termination and the limit on sizes are those of the tracker. A confirmed track keeps the points in its box together:
one that covers two merged vehicles affects later segments.
"""

import numpy as np

from luxloop.scenarios.arrays import Bools, Ints
from luxloop.scenarios.oracle.oracle_context import OracleContext
from luxloop.scenarios.oracle.stage import Stage
from luxloop.tracker.merging import MergeConfig
from luxloop.tracker.records import Status
from luxloop.tracker.tracking.model_selection import ModelSelection
from luxloop.tracker.tracking.observations import Observations
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_management import DefaultTrackManagement
from luxloop.tracker.tracking.track_table import TrackTable
from luxloop.tracker.tracking.traffic_flow import TrafficFlow


class OracleConfirmation(DefaultTrackManagement):
    """The track management of the shipped tracker, with true confirmation if `stages` has it."""

    def __init__(
        self,
        merging: MergeConfig,
        track: TrackConfig,
        stages: frozenset[Stage],
        context: OracleContext,
    ) -> None:
        super().__init__(merging, track)
        self._active = Stage.CONFIRMATION in stages
        self._context = context

    def settle(self, tracks: TrackTable) -> None:
        """Update the status of every track; the truth confirms those that were seen."""
        super().settle(tracks)
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

"""Track management: status, merging of pieces, removal of duplicates, and new tracks."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from luxloop.tracker.arrays import Bools, Ints
from luxloop.tracker.geometry import inside
from luxloop.tracker.merging import MergeConfig, RigidPairs, fits, hull, may_be_one, one_vehicle
from luxloop.tracker.records import NO_TRACK, Status
from luxloop.tracker.tracking import orientation, track_arrays
from luxloop.tracker.tracking.model_selection import ModelSelection
from luxloop.tracker.tracking.observations import Observations
from luxloop.tracker.tracking.track import Track
from luxloop.tracker.tracking.track_arrays import likely_sizes, pieces, seen_sizes, tracked_corners, within
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_observation import first_observation
from luxloop.tracker.tracking.traffic_flow import TrafficFlow
from luxloop.tracker.tracking.vehicle_size import SizeEstimator


class TrackManagement(Protocol):
    """Start, confirmation, merging and termination of tracks."""

    def manage(
        self, tracks: Sequence[Track], seen: Observations, track_id: Ints, forward: float, models: ModelSelection
    ) -> list[Track]:
        """Decide on the tracks at the end of a frame, after their updates.

        Parameters
        ----------
        tracks
            All tracks of this frame.
        seen
            The B boxes of this frame.
        track_id
            (B,) track of each box, `NO_TRACK` for none. Ids of new tracks are written into it.
        forward
            Heading of the ego in the odometry frame [rad].
        models
            Maker of filter banks for new tracks.

        Returns
        -------
        list of Track
            Tracks to report: living ones, and with `Status.DEAD` those that were terminated in this frame.
        """


class DefaultTrackManagement:
    """The track management of the shipped tracker. Each step is a method, which a replacement can reuse."""

    def __init__(self, merging: MergeConfig, track: TrackConfig) -> None:
        self._merging = merging
        self._track = track
        self._rigid = RigidPairs()
        self._next_id = 0

    def manage(
        self, tracks: Sequence[Track], seen: Observations, track_id: Ints, forward: float, models: ModelSelection
    ) -> list[Track]:
        """Decide on the tracks at the end of a frame, see `TrackManagement.manage`."""
        flow = self.flow(tracks, forward)
        self.orient(tracks, flow)
        self.settle(tracks)
        self.couple(tracks)
        self.merge(tracks)
        self.remove_duplicates(tracks)
        return [*tracks, *self.start(self.newcomers(tracks, seen, track_id), seen, track_id, flow, models)]

    def flow(self, tracks: Sequence[Track], forward: float) -> TrafficFlow:
        """Return the directions of the tracks, beside an ego of heading `forward` [rad]."""
        return track_arrays.flow(tracks, forward)

    def orient(self, tracks: Sequence[Track], flow: TrafficFlow) -> None:
        """Turn stationary vehicles to their likeliest directions, beside the other vehicles of `flow`."""
        for track in tracks:
            if track.seen:
                track.orient(flow)

    def settle(self, tracks: Sequence[Track]) -> None:
        """Update the status of every track."""
        for track in tracks:
            track.settle()

    def couple(self, tracks: Sequence[Track]) -> None:
        """Observe which tracks move as one rigid body."""
        visible = [track for track in tracks if track.seen]
        self._rigid.observe([track.id for track in visible], pieces(visible))

    def merge(self, tracks: Sequence[Track]) -> None:
        """Merge tracks that follow pieces of one vehicle; the track with more observations stays."""
        ranked = sorted((t for t in tracks if t.seen), key=lambda track: (not track.confirmed_now, -track.hits))
        seen = pieces(ranked)
        for a, b in may_be_one(seen):
            alive = Status.DEAD not in (ranked[a].status, ranked[b].status)
            together = one_vehicle(seen, a, b, self._merging) or self._rigid.rigid(ranked[a].id, ranked[b].id)
            still_fits = fits(seen, a, b)  # pieces that were merged before have grown
            if alive and ranked[a].confirmed_now and together and still_fits:
                ranked[a].absorb(*hull(seen, a, b))
                ranked[b].status = Status.DEAD
                seen = pieces(ranked)

    def remove_duplicates(self, tracks: Sequence[Track]) -> None:
        """Terminate every track inside the box of a confirmed one; of two confirmed tracks the older stays."""
        confirmed = [track for track in tracks if track.confirmed_now]
        ranked = confirmed + [track for track in tracks if not track.confirmed_now]
        corners = tracked_corners(ranked)
        center, *_ = corners.boxes(seen_sizes(ranked))
        vehicles = corners.first(len(confirmed)).boxes(likely_sizes(confirmed))
        rank, taken_by = np.nonzero(inside(center, *vehicles))
        for taken in rank[taken_by < rank].tolist():  # only those before a track take its place
            ranked[taken].status = Status.DEAD

    def newcomers(self, tracks: Sequence[Track], seen: Observations, track_id: Ints) -> Bools:
        """(B,) mask of boxes that start a track: assigned to none, and outside the boxes of confirmed tracks."""
        free = track_id == NO_TRACK
        if free.any():
            confirmed = [track for track in tracks if track.status is Status.CONFIRMED]
            free &= ~within(seen.center, confirmed).any(axis=1)
        return np.asarray(free)

    def start(
        self, newcomers: Bools, seen: Observations, track_id: Ints, flow: TrafficFlow, models: ModelSelection
    ) -> list[Track]:
        """Return a tentative track for each box of the mask `newcomers` (B,); write their ids into `track_id` (B,)."""
        started = [self._start_track(seen, b, flow, models) for b in np.flatnonzero(newcomers).tolist()]
        track_id[newcomers] = [track.id for track in started]
        return started

    def _start_track(self, seen: Observations, b: int, flow: TrafficFlow, models: ModelSelection) -> Track:
        """Return a tentative track of box `b`."""
        size, whole = seen.size[b], seen.whole[b]
        shape = orientation.shape_log_odds(size, whole)
        turns = orientation.likeliest_turns(shape, seen.center[b], float(seen.heading[b]), flow, least=0.0)
        usual = SizeEstimator(*orientation.turn_sides(size, whole, turns), self._track.extent).size
        first, position = first_observation(seen, b, turns, usual)
        bank = models.new_bank(position, first.covariance)
        track = Track(self._next_id, position, first, self._track, bank)
        self._next_id += 1
        return track

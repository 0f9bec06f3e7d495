"""Track management: status, merging of pieces, removal of duplicates, and new tracks."""

from typing import Protocol

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.tracker.geometry import QUARTER, rotate_one, variance_along, wrap
from luxloop.tracker.merging import MergeConfig, fits, hull, may_be_one, one_vehicle
from luxloop.tracker.records import NO_TRACK, OrientedBoxes
from luxloop.tracker.tracking import confirmation, correction, heading, orientation, vehicle_size
from luxloop.tracker.tracking.corner import end_variance
from luxloop.tracker.tracking.filters import initial_filters
from luxloop.tracker.tracking.hypotheses import shows_end
from luxloop.tracker.tracking.model_selection import ModelSelection
from luxloop.tracker.tracking.observations import Observations, uncut
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_table import CONFIRMED, DEAD, TENTATIVE, TrackTable, empty
from luxloop.tracker.tracking.traffic_flow import TrafficFlow, TrafficSide
from luxloop.tracker.tracking.vehicle_rows import IN_ROW_LOG_ODDS, in_row
from luxloop.tracker.vehicle_classes import WIDE_M


class TrackManagement(Protocol):
    """Start, confirmation, merging and termination of tracks."""

    def manage(
        self,
        tracks: TrackTable,
        observations: Observations,
        track_id: Ints,
        ego_pose: Floats,
        selection: ModelSelection,
    ) -> TrackTable:
        """Decide on the tracks at the end of a frame, after their updates.

        Parameters
        ----------
        tracks
            All tracks of this frame; changed in place.
        observations
            The B boxes of this frame.
        track_id
            (B,) track of each box, `NO_TRACK` for none. Ids of new tracks are written into it.
        ego_pose
            (3,) x, y [m] and heading [rad] of the ego in the odometry frame.
        selection
            Model selection, which reports the states of new and of merged tracks.

        Returns
        -------
        TrackTable
            Tracks to report: living ones, and with `Status.DEAD` those that were terminated in this frame.
        """


class DefaultTrackManagement:
    """The track management of the shipped tracker. Each step is a method, which a replacement can reuse."""

    def __init__(self, merging: MergeConfig, config: TrackConfig) -> None:
        self._merging = merging
        self._config = config
        self._next_id = 0
        self._side = TrafficSide()

    def manage(
        self,
        tracks: TrackTable,
        observations: Observations,
        track_id: Ints,
        ego_pose: Floats,
        selection: ModelSelection,
    ) -> TrackTable:
        """Decide on the tracks at the end of a frame, see `TrackManagement.manage`."""
        every, flow = np.arange(len(tracks)), self.flow(tracks, ego_pose)
        self.orient(tracks, flow)
        self.settle(tracks, ego_pose)
        self.merge(tracks, every, selection)
        self.remove_duplicates(tracks, every)
        return self.start(
            tracks, self.newcomers(tracks, observations, track_id), observations, track_id, flow, selection
        )

    def flow(self, tracks: TrackTable, ego_pose: Floats) -> TrafficFlow:
        """Return the tracks whose direction is known, beside an ego at x, y [m] and heading [rad] (3,).

        Oncoming vehicles among them show the side of traffic, which is remembered.
        """
        moved = tracks.subset(tracks.oriented & (tracks.status == CONFIRMED))
        self._side.observe(moved.id, moved.estimate[:, :2], moved.heading, ego_pose)
        known = tracks.subset(tracks.shows_direction)
        place, heading = known.estimate[:, :2].copy(), known.heading.copy()
        return TrafficFlow(known.id, place, heading, known.oriented, ego_pose, self._side.keeps_right)

    def orient(self, tracks: TrackTable, flow: TrafficFlow) -> None:
        """Turn stationary vehicles to their likeliest directions, beside the other vehicles of `flow`.

        Motion has precedence, unless the vehicle is too wide.
        """
        filtered = heading.heading_filter(self._config.filters)
        for t in np.flatnonzero(tracks.updated).tolist():
            moved = tracks.oriented[t] and tracks.visible_size[t, 1] <= WIDE_M
            if moved or correction.course_of(tracks, t, filtered) is not None:
                tracks.axis_log_odds[t] = np.inf
                continue
            others, (x, y, yaw, _, _) = flow.without(tracks.id.item(t)), confirmation.footprint(tracks, t)
            place, by_shape = np.array([x, y]), heading.length_log_odds(tracks, t)
            turns = orientation.likeliest_turns(by_shape, place, yaw, others, orientation.TURN_LOG_ODDS)
            correction.turn(tracks, t, turns)
            axis = others.axis_log_odds(place, tracks.yaw.item(t, 0))
            tracks.axis_log_odds[t] = heading.length_log_odds(tracks, t) + axis

    def settle(self, tracks: TrackTable, ego_pose: Floats) -> None:
        """Confirm or refute the tracks that were seen, by their views and motion, and by the rows that they are in."""
        settings = self._config.confirmation
        least = confirmation.log_odds(settings.confirm_probability)
        log_odds = np.array([confirmation.vehicle_odds(tracks, t) for t in range(len(tracks))])
        vehicles = tracks.confirmed_now & (log_odds >= least)
        log_odds += IN_ROW_LOG_ODDS * in_row(tracks.boxes(tracks.size), vehicles, ego_pose)
        for t in np.flatnonzero(tracks.updated & tracks.alive).tolist():
            odds = log_odds.item(t)
            sure = tracks.axis_log_odds[t] >= orientation.TURN_LOG_ODDS
            if sure and tracks.hits[t] >= settings.confirm_hits and odds >= least:
                tracks.status[t] = CONFIRMED
            elif odds <= -least:
                tracks.status[t] = TENTATIVE

    def merge(self, tracks: TrackTable, rows: Ints, selection: ModelSelection) -> None:
        """Merge those of the tracks `rows` that follow pieces of one vehicle; the one with more observations stays."""
        rows = rows[tracks.updated[rows]]
        confirmed = tracks.confirmed_now
        ranked = rows[np.lexsort((-tracks.hits[rows], ~confirmed[rows]))]
        pieces = visible_parts(tracks, ranked)
        for a, b in may_be_one(pieces):
            alive = (tracks.status[ranked[[a, b]]] != DEAD).all()
            together = one_vehicle(pieces, a, b, self._merging)
            still_fits = fits(pieces, a, b)  # pieces that were merged before have grown
            if alive and confirmed[ranked[a]] and together and still_fits:
                correction.absorb(tracks, ranked.item(a), *hull(pieces, a, b), selection, self._config)
                tracks.status[ranked[b]] = DEAD
                pieces = visible_parts(tracks, ranked)

    def remove_duplicates(self, tracks: TrackTable, rows: Ints) -> None:
        """Terminate those of the tracks `rows` inside the box of a confirmed one; of two confirmed, the older stays."""
        now = tracks.confirmed_now[rows]
        rows, confirmed = np.concatenate([rows[now], rows[~now]]), int(now.sum())
        ranked = tracks.subset(rows)
        visible, vehicles = ranked.boxes(ranked.visible_size), ranked.subset(np.arange(confirmed))
        rank, taken_by = np.nonzero(vehicles.within(visible.center))
        tracks.status[rows[rank[taken_by < rank]]] = DEAD  # only those before a track take its place

    def newcomers(self, tracks: TrackTable, observations: Observations, track_id: Ints) -> Bools:
        """(B,) mask of boxes that start a track: assigned to none, and outside the boxes of confirmed tracks."""
        free = track_id == NO_TRACK
        if free.any():
            free &= ~tracks.subset(tracks.status == CONFIRMED).within(observations.center).any(axis=1)
        return np.asarray(free)

    def start(
        self,
        tracks: TrackTable,
        newcomers: Bools,
        observations: Observations,
        track_id: Ints,
        flow: TrafficFlow,
        selection: ModelSelection,
    ) -> TrackTable:
        """Return the tracks, and a tentative one for each box of the mask `newcomers` (B,).

        Their ids are written into `track_id` (B,).
        """
        boxes = np.flatnonzero(newcomers).tolist()
        started = [new_track(observations, b, self._next_id + k, flow, self._config) for k, b in enumerate(boxes)]
        track_id[newcomers] = self._next_id + np.arange(len(started))
        self._next_id += len(started)
        joined = tracks.joined(started)
        rows = np.arange(len(tracks), len(joined))
        selection.summarise(joined, rows)
        return joined


def visible_parts(tracks: TrackTable, rows: Ints) -> OrientedBoxes:
    """Return the visible parts of the vehicles of `rows`."""
    of_rows = tracks.subset(rows)
    return of_rows.boxes(of_rows.visible_size)


def new_track(boxes: Observations, b: int, id: int, flow: TrafficFlow, config: TrackConfig) -> TrackTable:
    """Return a table of one tentative track of box `b`, in its likeliest direction beside the vehicles of `flow`."""
    shape = orientation.shape_log_odds(boxes.size[b], boxes.untruncated[b])
    turns = orientation.likeliest_turns(shape, boxes.center[b], float(boxes.heading[b]), flow, least=0.0)
    size, near = (
        orientation.turn_size(boxes.size[b], turns),
        orientation.turn_sign(boxes.corner_sign[b], turns),
    )
    cut = np.concatenate([boxes.cut[b, turns:], boxes.cut[b, :turns]])
    yaw, untruncated = wrap(float(boxes.heading[b]) + turns * QUARTER), uncut(cut)
    likelihood, of_pieces, views, usual, size_std = vehicle_size.first_view(size, untruncated)
    covariance = boxes.covariance[b, :2, :2]
    known = shows_end(size, near, cut, usual), variance_along(covariance, yaw)
    variance = np.where(*known, end_variance(2.0 * size_std, config.corner))
    position = boxes.center[b] + rotate_one(0.5 * boxes.corner_sign[b] * boxes.size[b], boxes.heading.item(b))
    track = empty(config.filters.models, rows=1)
    mean, spread = initial_filters(position, covariance, config.filters)
    turn = heading.Turn.start(yaw, float(boxes.covariance[b, 2, 2]), 0.0)
    heading.write(track.yaw, track.yaw_covariance, 0, turn)
    columns: dict[str, Floats | Ints | float] = {
        "id": id, "hits": 1, "status": TENTATIVE, "first_offset_s": float(boxes.time_offset[b]),
        "mean": mean, "covariance": spread, "probability": 1.0 / len(config.filters.models),
        "independent_mean": mean, "independent_covariance": spread,
        "corner_sign": near, "corner_variance": variance, "contradicted_from": position, "visible_size": size,
        "size_likelihood": likelihood, "piece_likelihood": of_pieces, "size_views": views, "size": usual,
        "size_std": size_std, "prior_log_odds": confirmation.log_odds(config.confirmation.vehicle_prior),
    }  # fmt: skip
    for name, value in columns.items():
        getattr(track, name)[0] = value
    heading.observe_sides(track, 0, size, untruncated)
    confirmation.count_view(track, 0, size, untruncated, bool(boxes.flat[b]))
    return track

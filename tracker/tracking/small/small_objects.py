"""Tracking of small road users beside the vehicles: association, confirmation and report."""

from collections.abc import Sequence

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import inside
from tracker.records import SmallBoxes, Status, Tracks
from tracker.tracking import track_arrays
from tracker.tracking.association import assign
from tracker.tracking.small import small_output, small_tracks
from tracker.tracking.small.small_config import SmallConfig
from tracker.tracking.small.small_tracks import SmallTracks
from tracker.tracking.track import Track

FIRST_ID = 1_000_000
"""First id of small road users: those of vehicles count from 0."""
FORBIDDEN = 1e9
"""Cost of a pair outside the gate."""


class SmallObjects:
    """Tracks of people and bicycles. The vehicles and their tracks do not depend on them.

    A segment in the box of a vehicle belongs to that vehicle. A bicycle that the vehicle stages track, too, is reported
    once: as their track, with the id of the small one if that was there before.
    """

    def __init__(self, config: SmallConfig) -> None:
        self._config = config
        self._tracks = small_tracks.empty()
        self._next_id = FIRST_ID
        self._reported_id: dict[int, int] = {}
        """Id under which a track is reported, by its own."""

    def step(self, boxes: SmallBoxes, vehicles: Sequence[Track], dt: float) -> None:
        """Update all tracks by the small boxes of a scan, `dt` [s] after the last one.

        Parameters
        ----------
        vehicles
            All tracks of the vehicle stages after their updates.
        """
        config = self._config
        living = self._tracks.subset(self._tracks.status != Status.DEAD)
        tracks = small_tracks.predict(living, dt, config)
        boxes = boxes.subset(~self._on_vehicle(boxes.center, vehicles))
        distance = small_tracks.distances(tracks, boxes, config)
        pairs = assign(distance, distance <= config.gate)
        row, box = (np.array([pair[k] for pair in pairs], dtype=np.int64) for k in (0, 1))
        tracks = small_tracks.update(tracks, boxes, row, box, config)
        new = small_tracks.start(boxes.subset(np.setdiff1d(np.arange(len(boxes)), box)), self._next_id, config)
        self._next_id += len(new)
        self._tracks = small_tracks.settle(small_tracks.join(tracks, new), config)
        confirmed = [one for one in vehicles if one.status is Status.CONFIRMED]
        on_vehicle = self._on_vehicle(self._tracks.mean[:, :2], confirmed) | self._attached(confirmed)
        self._tracks.status[on_vehicle] = int(Status.DEAD)

    def report(self, vehicles: Sequence[Track], tracks: Tracks, ego_odom: Floats) -> Tracks:
        """Return the record of the `vehicles` with the confirmed and coasting small road users, and the classes of all.

        Parameters
        ----------
        vehicles
            Tracks of the vehicle stages.
        tracks
            Their record.
        ego_odom
            (2,) position of the ego [m].
        """
        small = np.array([self.is_small(one) for one in vehicles], dtype=np.bool_)
        reported = np.isin(self._tracks.status, (Status.CONFIRMED, Status.COASTING))
        shown = self._tracks.subset(reported)
        kept = np.ones(len(tracks), dtype=np.bool_)
        hidden = np.zeros(len(shown), dtype=np.bool_)
        for t, vehicle in enumerate(vehicles):
            near = self._same_object(vehicle, shown)
            whole = bool((vehicle.whole_views >= self._config.whole_views_min).all())
            if near.any() and whole and not small[t]:  # its size is the prior: all of it was seen, and that is small
                kept[t] = False
            else:
                hidden |= near
            for k in np.flatnonzero(near).tolist():
                self._name_alike(vehicle.id, int(shown.id[k]))
        shown = shown.subset(~hidden)
        confirmed = tracks.status == Status.CONFIRMED
        own, unique = _distinct(self._ids(tracks.id), tracks.id, confirmed)
        kept &= unique
        others = self._ids(shown.id)
        _, first = np.unique(others, return_index=True)
        shown, others = shown.subset(first), others[first]
        kept &= confirmed | ~np.isin(own, others)
        fresh = ~np.isin(others, own[kept])
        for one in (*tracks.id[kept & confirmed].tolist(), *shown.id[fresh].tolist()):
            self._reported_id.setdefault(one, one)
        return small_output.appended(
            tracks, kept, own, small, shown.subset(fresh), others[fresh], ego_odom, self._config
        )

    def _same_object(self, vehicle: Track, shown: SmallTracks) -> Bools:
        """(K,) mask of the small road users that a confirmed track of the vehicle stages follows, too."""
        if not (vehicle.status is Status.CONFIRMED and self.looks_small(vehicle)):
            return np.zeros(len(shown), dtype=np.bool_)
        offset = shown.mean[:, :2] - vehicle.footprint.center
        return np.asarray(np.hypot(offset[:, 0], offset[:, 1]) < self._config.same_m)

    def looks_small(self, vehicle: Track) -> bool:
        """Return True for a track of the vehicle stages that was never seen larger than a bicycle."""
        length, width = vehicle.seen_size.tolist()
        return bool(length <= self._config.longer_max_m and width <= self._config.wider_max_m)

    def is_small(self, vehicle: Track) -> bool:
        """Return True for one whose estimated size is that of a bicycle, too, and not that of a hidden vehicle."""
        return self.looks_small(vehicle) and vehicle.size.item(1) <= self._config.wider_max_m

    def _on_vehicle(self, points: Floats, vehicles: Sequence[Track]) -> Bools:
        """(P,) mask of points (P, 2) in the boxes of vehicles that are not small, with a margin."""
        return np.asarray(self._in_boxes(points, vehicles, self._config.vehicle_margin_m).any(axis=1))

    def _attached(self, vehicles: Sequence[Track]) -> Bools:
        """(K,) mask of the tracks that move with a vehicle beside them."""
        large = [one for one in vehicles if self._is_large(one)]
        near = self._in_boxes(self._tracks.mean[:, :2], large, self._config.attached_m)
        velocity = track_arrays.velocities(large)
        difference = np.linalg.norm(self._tracks.mean[:, None, 2:] - velocity[None], axis=2)
        limit = self._config.attached_speed_mps
        moving = np.hypot(velocity[:, 0], velocity[:, 1]) > limit
        return np.asarray((near & (difference < limit) & moving).any(axis=1))

    def _in_boxes(self, points: Floats, vehicles: Sequence[Track], margin_m: float) -> Bools:
        """(P, L) mask of points (P, 2) in the boxes of those of the vehicles that are not small, with a margin [m]."""
        large = [one for one in vehicles if self._is_large(one)]
        if not large or not len(points):
            return np.zeros((len(points), len(large)), dtype=np.bool_)
        size = track_arrays.likely_sizes(large)
        center, heading, _ = track_arrays.from_corners(large, size)
        return np.asarray(inside(points, center, heading, size + 2.0 * margin_m))

    def _is_large(self, vehicle: Track) -> bool:
        """Return True for a track of this frame that is probably of a vehicle, because it was seen to be larger."""
        if not vehicle.seen or vehicle.status is Status.DEAD:
            return False
        if vehicle.status is Status.TENTATIVE:  # its axes may be swapped
            return bool(max(vehicle.seen_size.tolist()) > self._config.longer_max_m)
        return not self.looks_small(vehicle)

    def _name_alike(self, vehicle: int, small: int) -> None:
        """Report two tracks of one object under one id, that of the track that was reported first."""
        names = self._reported_id
        if small in names and vehicle not in names:
            names[vehicle] = names[small]
        else:
            names[small] = names.setdefault(vehicle, vehicle)

    def _ids(self, own: Ints) -> Ints:
        """Return the reported ids of tracks."""
        return np.array([self._reported_id.get(one, one) for one in own.tolist()], dtype=np.int64)


def _distinct(reported: Ints, own: Ints, confirmed: Bools) -> tuple[Ints, Bools]:
    """Return ids (T,) of which none occurs twice, and a mask (T,) of the rows that have one.

    Confirmed tracks come first. A second row of an id gets its `own` one, if that is free.
    """
    ids, unique, used = reported.copy(), np.ones(len(reported), dtype=np.bool_), set[int]()
    for t in np.argsort(~confirmed, kind="stable").tolist():
        if ids[t] in used:
            ids[t] = own[t]
        unique[t] = ids[t] not in used
        used.add(int(ids[t]))
    return ids, unique

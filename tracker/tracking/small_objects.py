"""Tracking of small road users beside the vehicles: association, confirmation and report."""

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.geometry import inside, rotate
from luxloop.tracker.records import PREDICTION_S, SmallBoxes, Status, Tracks
from luxloop.tracker.tracking import small_tracks, track_arrays
from luxloop.tracker.tracking.association import assign
from luxloop.tracker.tracking.small_tracks import SmallTracks
from luxloop.tracker.tracking.track import Track

FIRST_ID = 1_000_000
"""First id of small road users: those of vehicles count from 0."""
FORBIDDEN = 1e9
"""Cost of a pair outside the gate."""


class LargeVehicles(NamedTuple):
    """Likely parts of L vehicles, odometry frame."""

    center: Floats
    """(L, 2) [m]."""
    heading: Floats
    """(L,) [rad]."""
    size: Floats
    """(L, 2) length and width [m]."""
    velocity: Floats
    """(L, 2) [m/s]."""
    is_confirmed: Bools
    """(L,) mask of confirmed tracks."""

    def confirmed(self) -> "LargeVehicles":
        """Return the vehicles with confirmed tracks."""
        of = self.is_confirmed
        return LargeVehicles(self.center[of], self.heading[of], self.size[of], self.velocity[of], self.is_confirmed[of])

    def cover(self, points: Floats, margin_m: float) -> Bools:
        """(P, L) mask of points (P, 2) in the boxes of the vehicles, with a margin [m]."""
        return inside(points, self.center, self.heading, self.size + 2.0 * margin_m)


class SmallObjects:
    """Tracks of people and bicycles. The vehicles and their tracks do not depend on them.

    A segment in the box of a vehicle belongs to that vehicle. A bicycle that the vehicle stages track, too, is reported
    once: as their track, with the id of the small one if that was there before.
    """

    def __init__(self) -> None:
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
        if not len(self._tracks) and not len(boxes):
            return
        large = self._large(vehicles)
        living = self._tracks.status != Status.DEAD.value  # numpy compares members of an enumeration ten times slower
        tracks = self._tracks if living.all() else self._tracks.subset(living)
        if len(tracks):
            small_tracks.predict(tracks, dt)
        boxes = boxes.subset(np.flatnonzero(~large.cover(boxes.center, small_tracks.VEHICLE_MARGIN_M).any(axis=1)))
        row, box = self._pairs(tracks, boxes)
        if len(row):
            small_tracks.update(tracks, boxes, row, box)
        free = np.ones(len(boxes), dtype=np.bool_)
        free[box] = False
        if free.any():
            tracks = small_tracks.join(tracks, small_tracks.start(boxes.subset(free), self._next_id))
            self._next_id += int(np.count_nonzero(free))
        self._tracks = tracks
        if len(tracks):
            small_tracks.settle(tracks)
            tracks.status[self._of_vehicles(large.confirmed())] = int(Status.DEAD)

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
        status = self._tracks.status
        reported = (status == Status.CONFIRMED.value) | (status == Status.COASTING.value)
        shown = self._tracks.subset(reported)
        kept, hidden = self._without_doubles(vehicles, small, shown)
        confirmed = tracks.status == Status.CONFIRMED.value
        own, unique = _distinct(self._ids(tracks.id), tracks.id, confirmed)
        kept &= unique
        fresh, others = np.flatnonzero(~hidden), np.zeros(0, dtype=np.int64)
        if len(fresh):
            others, first = np.unique(self._ids(shown.id[fresh]), return_index=True)
            kept &= confirmed | ~np.isin(own, others)
            free = ~np.isin(others, own[kept])
            fresh, others = fresh[first][free], others[free]
        for one in (*tracks.id[kept & confirmed].tolist(), *shown.id[fresh].tolist()):
            self._reported_id.setdefault(one, one)
        return appended(tracks, kept, own, small, shown.subset(fresh), others, ego_odom)

    def _without_doubles(self, vehicles: Sequence[Track], small: Bools, shown: SmallTracks) -> tuple[Bools, Bools]:
        """Return masks of the vehicles (T,) to report, and of the small road users (K,) that a vehicle's track follows.

        The reported ids of both become alike. `small` (T,) is the class of the vehicles.
        """
        kept, hidden = np.ones(len(vehicles), dtype=np.bool_), np.zeros(len(shown), dtype=np.bool_)
        for t, vehicle in enumerate(vehicles if len(shown) else ()):
            near = self._same_object(vehicle, shown)
            if not near.any():
                continue
            whole = bool((vehicle.whole_views >= small_tracks.WHOLE_VIEWS_MIN).all())
            if whole and not small[t]:  # its size is the prior: all of it was seen, and that is small
                kept[t] = False
            else:
                hidden |= near
            for k in np.flatnonzero(near).tolist():
                self._name_alike(vehicle.id, int(shown.id[k]))
        return kept, hidden

    def _pairs(self, tracks: SmallTracks, boxes: SmallBoxes) -> tuple[Ints, Ints]:
        """Return the tracks (P,) and the boxes (P,) of the assigned pairs."""
        pairs: list[tuple[int, int]] = []
        if len(tracks) and len(boxes):
            distance = small_tracks.distances(tracks, boxes)
            pairs = assign(distance, distance <= small_tracks.GATE_CHI2)
        row, box = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
        return row, box

    def _same_object(self, vehicle: Track, shown: SmallTracks) -> Bools:
        """(K,) mask of the small road users that a confirmed track of the vehicle stages follows, too."""
        if not (vehicle.status is Status.CONFIRMED and self.looks_small(vehicle)):
            return np.zeros(len(shown), dtype=np.bool_)
        offset = shown.mean[:, :2] - vehicle.footprint.center
        return np.asarray(np.hypot(offset[:, 0], offset[:, 1]) < small_tracks.SAME_M)

    def looks_small(self, vehicle: Track) -> bool:
        """Return True for a track of the vehicle stages that was never seen larger than a bicycle."""
        length, width = vehicle.seen_size.tolist()
        return bool(length <= small_tracks.LENGTH_MAX_M and width <= small_tracks.WIDTH_MAX_M)

    def is_small(self, vehicle: Track) -> bool:
        """Return True for one whose estimated size is that of a bicycle, too, and not that of a hidden vehicle."""
        return self.looks_small(vehicle) and vehicle.size.item(1) <= small_tracks.WIDTH_MAX_M

    def _of_vehicles(self, vehicles: LargeVehicles) -> Bools:
        """(K,) mask of the tracks in the boxes of vehicles, with a margin, or that move with a vehicle beside them."""
        mean = self._tracks.mean
        near = vehicles.cover(mean[:, :2], small_tracks.ATTACHED_M)
        difference = np.linalg.norm(mean[:, None, 2:] - vehicles.velocity[None], axis=2)
        moving = np.hypot(vehicles.velocity[:, 0], vehicles.velocity[:, 1]) > small_tracks.ATTACHED_SPEED_MPS
        attached = near & (difference < small_tracks.ATTACHED_SPEED_MPS) & moving
        return np.asarray((vehicles.cover(mean[:, :2], small_tracks.VEHICLE_MARGIN_M) | attached).any(axis=1))

    def _large(self, vehicles: Sequence[Track]) -> LargeVehicles:
        """Return the likely parts of those of the vehicles that are not small."""
        large = [one for one in vehicles if self._is_large(one)]
        corners = track_arrays.tracked_corners(large)
        confirmed = np.array([one.status is Status.CONFIRMED for one in large], dtype=np.bool_)
        return LargeVehicles(*corners.boxes(track_arrays.likely_sizes(large)), corners.velocity, confirmed)

    def _is_large(self, vehicle: Track) -> bool:
        """Return True for a track of this frame that is probably of a vehicle, because it was seen to be larger."""
        if not vehicle.seen or vehicle.status is Status.DEAD:
            return False
        if vehicle.status is Status.TENTATIVE:  # its axes may be swapped
            return bool(max(vehicle.seen_size.tolist()) > small_tracks.LENGTH_MAX_M)
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
    ids, names, unique, used = reported.tolist(), own.tolist(), np.ones(len(reported), dtype=np.bool_), set[int]()
    if len(set(ids)) == len(ids):
        return reported, unique
    for t in np.argsort(~confirmed, kind="stable").tolist():
        if ids[t] in used:
            ids[t] = names[t]
        unique[t] = ids[t] not in used
        used.add(ids[t])
    return np.array(ids, dtype=np.int64), unique


ABEAM_M = 1.0
"""Distance along an axis over which the near end changes [m]: from abeam, both ends of a bicycle are visible."""
_COLUMNS = tuple(field.name for field in fields(Tracks))


def appended(
    tracks: Tracks,
    kept: Bools,
    own_id: Ints,
    small: Bools,
    added: SmallTracks,
    added_id: Ints,
    ego_odom: Floats,
) -> Tracks:
    """Return the rows `kept` (T,) of a record, renamed to `own_id` (T,), then a row for each small road user.

    Parameters
    ----------
    small
        (T,) class of the rows of the record.
    added_id
        (K,) reported ids.
    ego_odom
        (2,) position of the ego [m].
    """
    if kept.all() and not len(added):
        return replace(tracks, id=own_id, small=small)
    own: dict[str, Any] = {name: values for name in _COLUMNS if isinstance(values := getattr(tracks, name), np.ndarray)}
    own |= {"id": own_id, "small": small}
    if not kept.all():
        own = {name: values[kept] for name, values in own.items()}
    if len(added):
        rows = record(added, added_id, ego_odom, tracks.models)
        own = {name: np.concatenate([values, getattr(rows, name)]) for name, values in own.items()}
    return replace(tracks, **own)


def record(tracks: SmallTracks, ids: Ints, ego_odom: Floats, models: tuple[str, ...]) -> Tracks:
    """Return the record of small road users: the constant velocity model is the selected one, at the box centre."""
    count, m = len(tracks), len(models)
    center = centers(tracks, ego_odom)
    mean, covariance = np.zeros((count, 8)), np.zeros((count, 8, 8))
    mean[:, :2], mean[:, 2:4], mean[:, 6] = center, tracks.mean[:, 2:], tracks.heading
    covariance[:, :4, :4] = tracks.covariance
    covariance[:, [4, 5], [4, 5]] = small_tracks.ACCELERATION_STD_MPS2**2
    across = small_tracks.ACCELERATION_STD_MPS2 / np.maximum(tracks.speed, small_tracks.SPEED_MIN_MPS)
    variance = np.trace(tracks.covariance[:, 2:, 2:], axis1=1, axis2=2) / np.maximum(tracks.speed, 0.1) ** 2
    covariance[:, 6, 6], covariance[:, 7, 7] = variance, across**2
    model = models.index("cv") if "cv" in models else 0
    probability = np.zeros((count, m))
    probability[:, model] = 1.0
    ahead = center[:, None] + np.array(PREDICTION_S)[None, :, None] * tracks.mean[:, None, 2:]
    return Tracks(
        id=ids,
        status=tracks.status.astype(np.uint8),
        mean=mean,
        covariance=covariance,
        model_probability=probability,
        model=np.full(count, model),
        model_position_odom=np.repeat(center[:, None], m, axis=1),
        corner_sign=np.zeros((count, 2), dtype=np.int64),
        size=tracks.size,
        model_covariance_odom=np.repeat(tracks.covariance[:, None, :2, :2], m, axis=1),
        model_nis=np.full((count, m), np.nan),
        prediction_odom=np.repeat(ahead[:, None], m + 1, axis=1),
        small=np.ones(count, dtype=np.bool_),
        models=models,
    )


def centers(tracks: SmallTracks, ego_odom: Floats) -> Floats:
    """(K, 2) centres [m]: the hidden part of a box lies behind its visible points, seen from the ego."""
    from_ego = rotate(tracks.mean[:, :2] - ego_odom, -tracks.heading)
    hidden = np.maximum(tracks.size - tracks.extent, 0.0)
    return tracks.mean[:, :2] + rotate(0.5 * hidden * np.clip(from_ego / ABEAM_M, -1.0, 1.0), tracks.heading)

"""Tracking of small road users beside the vehicles: association, confirmation and report."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.tracker.geometry import rotate
from luxloop.tracker.kernels import inside
from luxloop.tracker.records import PREDICTION_S, SmallBoxes, Status, Tracks
from luxloop.tracker.tracking import confirmation, small_tracks
from luxloop.tracker.tracking.association import assign
from luxloop.tracker.tracking.small_tracks import SmallTracks
from luxloop.tracker.tracking.track_table import CONFIRMED, TENTATIVE, TrackTable

FIRST_ID = 1_000_000
"""First id of small road users: those of vehicles count from 0."""
FORBIDDEN = 1e9
"""Cost of a pair outside the gate."""


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

    def step(self, boxes: SmallBoxes, vehicles: TrackTable, dt: float) -> None:
        """Update all tracks by the small boxes of a scan, `dt` [s] after the last one.

        Parameters
        ----------
        vehicles
            All tracks of the vehicle stages after their updates.
        """
        if not len(self._tracks) and not len(boxes):
            return
        large = vehicles.subset(is_large(vehicles))
        living = self._tracks.status != Status.DEAD.value  # numpy compares members of an enumeration ten times slower
        tracks = self._tracks if living.all() else self._tracks.subset(living)
        if len(tracks):
            small_tracks.predict(tracks, dt)
        boxes = boxes.subset(np.flatnonzero(~cover(large, boxes.center, small_tracks.VEHICLE_MARGIN_M).any(axis=1)))
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
            tracks.status[self._of_vehicles(large.subset(large.status == CONFIRMED))] = int(Status.DEAD)

    def report(self, vehicles: TrackTable, tracks: Tracks, ego_odom: Floats) -> Tracks:
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
        small = is_small(vehicles)
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

    def _without_doubles(self, vehicles: TrackTable, small: Bools, shown: SmallTracks) -> tuple[Bools, Bools]:
        """Return masks of the vehicles (T,) to report, and of the small road users (K,) that a vehicle's track follows.

        The reported ids of both become alike. `small` (T,) is the class of the vehicles.
        """
        kept, hidden = np.ones(len(vehicles), dtype=np.bool_), np.zeros(len(shown), dtype=np.bool_)
        whole = np.all(vehicles.whole_views >= small_tracks.WHOLE_VIEWS_MIN, axis=1)
        for t in np.flatnonzero((vehicles.status == CONFIRMED) & looks_small(vehicles)).tolist():
            offset = shown.mean[:, :2] - confirmation.footprint(vehicles, t)[:2]
            near = elementwise.hypot(offset[:, 0], offset[:, 1]) < small_tracks.SAME_M
            if not near.any():
                continue
            if whole[t] and not small[t]:  # its size is the prior: all of it was seen, and that is small
                kept[t] = False
            else:
                hidden |= near
            for k in np.flatnonzero(near).tolist():
                self._name_alike(vehicles.id.item(t), int(shown.id[k]))
        return kept, hidden

    def _pairs(self, tracks: SmallTracks, boxes: SmallBoxes) -> tuple[Ints, Ints]:
        """Return the tracks (P,) and the boxes (P,) of the assigned pairs."""
        pairs: list[tuple[int, int]] = []
        if len(tracks) and len(boxes):
            distance = small_tracks.distances(tracks, boxes)
            pairs = assign(distance, distance <= small_tracks.GATE_CHI2)
        row, box = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
        return row, box

    def _of_vehicles(self, vehicles: TrackTable) -> Bools:
        """(K,) mask of the tracks in the boxes of vehicles, with a margin, or that move with a vehicle beside them."""
        mean = self._tracks.mean
        near, velocity = cover(vehicles, mean[:, :2], small_tracks.ATTACHED_M), vehicles.velocity
        difference = np.linalg.norm(mean[:, None, 2:] - velocity[None], axis=2)
        moving = elementwise.hypot(velocity[:, 0], velocity[:, 1]) > small_tracks.ATTACHED_SPEED_MPS
        attached = near & (difference < small_tracks.ATTACHED_SPEED_MPS) & moving
        return np.asarray((cover(vehicles, mean[:, :2], small_tracks.VEHICLE_MARGIN_M) | attached).any(axis=1))

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


def looks_small(vehicles: TrackTable) -> Bools:
    """(T,) mask of tracks of the vehicle stages that were never seen larger than a bicycle."""
    length, width = vehicles.visible_size.T
    return np.asarray((length <= small_tracks.LENGTH_MAX_M) & (width <= small_tracks.WIDTH_MAX_M))


def is_small(vehicles: TrackTable) -> Bools:
    """(T,) mask of those whose estimated size is that of a bicycle, too, and not that of a hidden vehicle."""
    return np.asarray(looks_small(vehicles) & (vehicles.size[:, 1] <= small_tracks.WIDTH_MAX_M))


def is_large(vehicles: TrackTable) -> Bools:
    """(T,) mask of tracks of this frame that are probably of vehicles, because they were seen to be larger."""
    longer = vehicles.visible_size.max(axis=1, initial=0.0) > small_tracks.LENGTH_MAX_M
    larger = np.where(vehicles.status == TENTATIVE, longer, ~looks_small(vehicles))  # axes may be swapped at first
    return np.asarray(vehicles.updated & vehicles.alive & larger)


def cover(vehicles: TrackTable, points: Floats, margin_m: float) -> Bools:
    """(P, T) mask of points (P, 2) in the likely parts of vehicles, with a margin [m]."""
    boxes = vehicles.boxes(vehicles.likely_size)
    return inside(points, boxes.center, boxes.heading, boxes.size + 2.0 * margin_m)


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

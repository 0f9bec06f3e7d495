"""Blockers of hidden vehicles: what the LIDARs' beams hit instead, counted per frame."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.frame_truth import IS_ON_NOTHING, IS_VEHICLE, FrameTruth
from luxloop.scenarios.grading.plane_geometry import wrap
from luxloop.sensor_model.truth import NO_ACTOR, Part

CORNERS = np.array([[0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]])
"""(4, 2) corners of a box, in units of its length and width."""


class BlockerLog:
    """Finds the blockers of hidden vehicles that were graded before; one log per run.

    Parameters
    ----------
    hidden_fraction_max
        A vehicle with at most this visible fraction is hidden, see `GradingConfig`.
    """

    def __init__(self, hidden_fraction_max: float) -> None:
        self._limit = hidden_fraction_max
        self._known: set[int] = set()

    def rows(self, frame_truth: FrameTruth) -> dict[str, npt.NDArray[Any]]:
        """Return the rows of the table `blockers` of one frame."""
        ids, truth = frame_truth.actors.id, frame_truth.truth
        self._known.update(ids[frame_truth.graded].tolist())
        hidden = (truth.visible_fraction <= self._limit) & (truth.hits_alone > 0) & IS_VEHICLE[frame_truth.actors.kind]
        rows = [row for row in np.flatnonzero(hidden).tolist() if int(ids[row]) in self._known]
        views = unit_views(frame_truth) if rows else []
        found = [(int(ids[row]), *pair) for row in rows for pair in blockers(frame_truth, views, row)]
        actor, blocker, points = np.array(found, dtype=np.int64).reshape(-1, 3).T
        return {"actor_id": actor, "blocker_id": blocker, "points": points}


class UnitView(NamedTuple):
    """P points on actors and static obstacles, as one LIDAR sees them."""

    origin: Floats
    """(2,) position of the LIDAR, ego frame [m]."""
    row: Ints
    """(P,) row of the actor, -1 for static obstacles."""
    range_m: Floats
    """(P,) distance from the LIDAR [m]."""
    bearing: Floats
    """(P,) bearing from the LIDAR, ego frame [rad]."""

    def in_front(self, box: Floats) -> Ints:
        """Return the rows of the points between the LIDAR and a box (5,) in the ego frame."""
        x, y, yaw, length, width = box
        cos, sin = np.cos(yaw), np.sin(yaw)
        corners = (CORNERS * (length, width)) @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
        middle = _bearing(box[:2] - self.origin)
        offsets = wrap(_bearing(corners - self.origin) - middle)
        nearer = np.flatnonzero(self.range_m < np.hypot(*(box[:2] - self.origin)))
        offset = wrap(self.bearing[nearer] - middle)
        rows: Ints = self.row[nearer[(offsets.min() <= offset) & (offset <= offsets.max())]]
        return rows


def unit_views(frame_truth: FrameTruth) -> list[UnitView]:
    """Return the view of each LIDAR."""
    truth, scan = frame_truth.truth, frame_truth.scan
    is_static = (truth.actor_id == NO_ACTOR) & (truth.part == Part.OBSTACLE)
    solid = (is_static | (frame_truth.point_row >= 0)) & ~IS_ON_NOTHING[truth.cause]
    views = []
    for unit in range(truth.unit_hits_alone.shape[1]):
        own = np.flatnonzero(solid & (scan.unit == unit))
        origin = np.zeros(2) if scan.unit_positions_ego is None else scan.unit_positions_ego[unit]
        ray = scan.points_ego.take(own, axis=0)[:, :2].astype(np.float64) - origin
        views.append(UnitView(origin, frame_truth.point_row[own], np.hypot(*ray.T), _bearing(ray)))
    return views


def blockers(frame_truth: FrameTruth, views: list[UnitView], row: int) -> Iterator[tuple[int, int]]:
    """Yield each blocker of the actor in a row with its number of points, in ascending order of ids.

    A blocker is an actor, or `NO_ACTOR` for static obstacles, with points in the angle under which a LIDAR would see
    the actor's box, and nearer than the centre of the box. Beams are evenly spaced in angle, so the number of points
    measures the covered part of this angle.
    """
    actors, points = frame_truth.actors.id, np.zeros(len(frame_truth.actors) + 1, dtype=np.int64)
    for unit in np.flatnonzero(frame_truth.truth.unit_hits_alone[row]).tolist():
        points += np.bincount(views[unit].in_front(frame_truth.boxes_ego[row]) + 1, minlength=len(points))
    points[row + 1] = 0
    for blocker in np.flatnonzero(points).tolist():
        yield NO_ACTOR if blocker == 0 else int(actors[blocker - 1]), int(points[blocker])


def _bearing(ray: Floats) -> Floats:
    """Return the bearings (...) of rays (..., 2) [rad]."""
    bearing: Floats = np.arctan2(ray[..., 1], ray[..., 0])
    return bearing

"""Blockers of hidden vehicles: what the LIDARs' beams hit instead, counted per frame."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from scenarios.arrays import Bools, Floats, Ints
from scenarios.grading.frame_truth import IS_VEHICLE, FrameTruth
from scenarios.grading.plane_geometry import wrap
from sensor_model.truth import NO_ACTOR, ON_NOTHING, Part

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
        found = [(int(ids[row]), *pair) for row in rows for pair in blockers(frame_truth, row)]
        actor, blocker, points = np.array(found, dtype=np.int64).reshape(-1, 3).T
        return {"actor_id": actor, "blocker_id": blocker, "points": points}


def blockers(frame_truth: FrameTruth, row: int) -> Iterator[tuple[int, int]]:
    """Yield each blocker of the actor in a row with its number of points, in ascending order of ids.

    A blocker is an actor, or `NO_ACTOR` for static obstacles, with points in the angle under which a LIDAR would see
    the actor's box, and nearer than the centre of the box. Beams are evenly spaced in angle, so the number of points
    measures the covered part of this angle.
    """
    truth = frame_truth.truth
    is_static = (truth.actor_id == NO_ACTOR) & (truth.part == Part.OBSTACLE)
    solid = (is_static | (frame_truth.point_row >= 0)) & ~np.isin(truth.cause, ON_NOTHING)
    solid &= frame_truth.point_row != row
    between = np.flatnonzero(solid)
    between = between[_in_front(frame_truth, between, row)]
    yield from zip(*(values.tolist() for values in np.unique(truth.actor_id[between], return_counts=True)), strict=True)


def _in_front(frame_truth: FrameTruth, points: Ints, row: int) -> Bools:
    """(P,) mask of points, by index, between their LIDAR and the box in a row."""
    scan, units = frame_truth.scan, frame_truth.truth.unit_hits_alone[row] > 0
    origins = scan.unit_positions_ego if scan.unit_positions_ego is not None else np.zeros((len(units), 2))
    x, y, yaw, length, width = frame_truth.boxes_ego[row]
    cos, sin = np.cos(yaw), np.sin(yaw)
    corners = (CORNERS * (length, width)) @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
    middle = _bearing(np.array([x, y]) - origins)
    offsets = wrap(_bearing(corners[:, None] - origins) - middle)  # (4, U)
    distance = np.hypot(*(np.array([x, y]) - origins).T)
    unit = scan.unit[points]
    ray = scan.points_ego[points, :2].astype(np.float64) - origins[unit]
    offset = wrap(_bearing(ray) - middle[unit])
    inside = (offsets.min(axis=0)[unit] <= offset) & (offset <= offsets.max(axis=0)[unit])
    nearer = np.hypot(*ray.T) < distance[unit]
    mask: Bools = inside & nearer & units[unit]
    return mask


def _bearing(ray: Floats) -> Floats:
    """Return the bearings (...) of rays (..., 2) [rad]."""
    bearing: Floats = np.arctan2(ray[..., 1], ray[..., 0])
    return bearing

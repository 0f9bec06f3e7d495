"""Blockers of hidden vehicles: what the LIDARs' beams hit instead, counted per frame."""

from collections.abc import Iterator
from dataclasses import dataclass
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
        solid = SolidPoints.of(frame_truth) if rows else None
        found = [(int(ids[row]), *pair) for row in rows if solid for pair in blockers(frame_truth, solid, row)]
        actor, blocker, points = np.array(found, dtype=np.int64).reshape(-1, 3).T
        return {"actor_id": actor, "blocker_id": blocker, "points": points}


@dataclass(frozen=True, slots=True, eq=False)
class SolidPoints:
    """P points of a frame on actors and static obstacles, as seen by their LIDARs."""

    actor_id: Ints
    """(P,) id of the actor, `NO_ACTOR` for static obstacles."""
    row: Ints
    """(P,) row of the actor, -1 for none."""
    unit: Ints
    """(P,) LIDAR."""
    range_m: Floats
    """(P,) distance from the LIDAR [m]."""
    bearing: Floats
    """(P,) bearing from the LIDAR, ego frame [rad]."""
    origins: Floats
    """(U, 2) positions of the LIDARs, ego frame [m]."""

    @classmethod
    def of(cls, frame_truth: FrameTruth) -> "SolidPoints":
        """Return the solid points of a frame."""
        truth, scan = frame_truth.truth, frame_truth.scan
        is_static = (truth.actor_id == NO_ACTOR) & (truth.part == Part.OBSTACLE)
        own = np.flatnonzero((is_static | (frame_truth.point_row >= 0)) & ~np.isin(truth.cause, ON_NOTHING))
        origins = scan.unit_positions_ego
        if origins is None:
            origins = np.zeros((truth.unit_hits_alone.shape[1], 2))
        unit = scan.unit[own].astype(np.int64)
        ray = scan.points_ego[own, :2].astype(np.float64) - origins[unit]
        return cls(
            actor_id=truth.actor_id[own],
            row=frame_truth.point_row[own],
            unit=unit,
            range_m=np.hypot(*ray.T),
            bearing=_bearing(ray),
            origins=origins,
        )


def blockers(frame_truth: FrameTruth, solid: SolidPoints, row: int) -> Iterator[tuple[int, int]]:
    """Yield each blocker of the actor in a row with its number of points, in ascending order of ids.

    A blocker is an actor, or `NO_ACTOR` for static obstacles, with points in the angle under which a LIDAR would see
    the actor's box, and nearer than the centre of the box. Beams are evenly spaced in angle, so the number of points
    measures the covered part of this angle.
    """
    seeing = frame_truth.truth.unit_hits_alone[row] > 0
    ids = solid.actor_id[_in_front(solid, frame_truth.boxes_ego[row], seeing) & (solid.row != row)]
    yield from zip(*(values.tolist() for values in np.unique(ids, return_counts=True)), strict=True)


def _in_front(solid: SolidPoints, box: Floats, seeing: Bools) -> Bools:
    """(P,) mask of points of LIDARs that are `seeing` (U,) between their LIDAR and a box (5,)."""
    x, y, yaw, length, width = box
    cos, sin = np.cos(yaw), np.sin(yaw)
    corners = (CORNERS * (length, width)) @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
    middle = _bearing(np.array([x, y]) - solid.origins)
    offsets = wrap(_bearing(corners[:, None] - solid.origins) - middle)  # (4, U)
    distance = np.where(seeing, np.hypot(*(np.array([x, y]) - solid.origins).T), 0.0)
    mask = solid.range_m < distance[solid.unit]
    nearer = np.flatnonzero(mask)
    unit = solid.unit[nearer]
    offset = wrap(solid.bearing[nearer] - middle[unit])
    mask[nearer] = (offsets.min(axis=0)[unit] <= offset) & (offset <= offsets.max(axis=0)[unit])
    return mask


def _bearing(ray: Floats) -> Floats:
    """Return the bearings (...) of rays (..., 2) [rad]."""
    bearing: Floats = np.arctan2(ray[..., 1], ray[..., 0])
    return bearing

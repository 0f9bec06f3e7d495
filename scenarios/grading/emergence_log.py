"""First frames of each stage of emergence: beams, points, tentative and confirmed tracks, located actors."""

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.plane_geometry import turned, wrap
from luxloop.scenarios.grading.track_matches import TrackMatches
from luxloop.scenarios.metrics.definitions import STAGES
from luxloop.sim.world import Kind
from luxloop.tracker.records import Status, Tracks

NO_ROW = -1


class EmergenceLog:
    """Records, frame by frame, which actors reach a stage for the first time.

    A track is on at most one actor: the one that it follows; or else, of those that it overlaps by `match_iou_min` or
    more, the one of the largest overlap; or else the nearest one whose centre is inside its box. The last rule is for
    people, who are much smaller than any box of a vehicle tracker. Coasting and dead tracks are on no actor. No track
    is on an actor before the first beam from it, because a box beside it may reach over a hidden actor.
    """

    def __init__(self, config: GradingConfig) -> None:
        self._config = config
        self.first: dict[str, dict[int, int]] = {stage: {} for stage in STAGES}
        """Frame index by actor id, for each stage that it has reached."""

    def add(self, frame_truth: FrameTruth, matches: TrackMatches, tracks: Tracks) -> None:
        """Record one frame."""
        row = _actor_rows(frame_truth, matches, tracks, self._config.match_iou_min)
        confirmed = tracks.status == Status.CONFIRMED
        reached = {
            "first_beam": np.flatnonzero(frame_truth.points > 0),
            "enough_points": np.flatnonzero(frame_truth.points >= self._config.points_min),
            "tentative": row,
            "confirmed": row[confirmed],
            "located": row[confirmed & self._located(frame_truth, matches.boxes_ego, row)],
        }
        seen = self.first["first_beam"]
        for stage, rows in reached.items():  # the first beam comes first
            for actor in frame_truth.actors.id[rows[rows != NO_ROW]].tolist():
                if stage == "first_beam" or actor in seen:
                    self.first[stage].setdefault(actor, frame_truth.frame.index)

    def _located(self, frame_truth: FrameTruth, boxes_ego: Floats, row: Ints) -> Bools:
        """(T,) mask of boxes (T, 5) near the pose of their actor (T,). The heading of people does not count."""
        located = np.zeros(len(row), np.bool_)
        on = np.flatnonzero(row != NO_ROW)
        error = boxes_ego[on, :3] - frame_truth.boxes_ego[row[on], :3]
        is_person = frame_truth.actors.kind[row[on]] == Kind.PEDESTRIAN
        turned = np.abs(wrap(error[:, 2])) <= np.deg2rad(self._config.located_heading_deg)
        near = np.hypot(error[:, 0], error[:, 1]) <= self._config.located_position_m
        located[on] = near & (turned | is_person)
        return located


def _actor_rows(frame_truth: FrameTruth, matches: TrackMatches, tracks: Tracks, iou_min: float) -> Ints:
    """(T,) row of the actor that each track is on, `NO_ROW` for none."""
    row = matches.actor_row.copy()
    live = (tracks.status == Status.TENTATIVE) | (tracks.status == Status.CONFIRMED)
    open_tracks = np.flatnonzero(live & (row == NO_ROW))
    if not len(frame_truth.actors) or not len(open_tracks):
        return row
    boxes = matches.boxes_ego[open_tracks]
    overlap = frame_truth.overlap(boxes)
    by_overlap = np.where(overlap.max(axis=0) >= iou_min, overlap.argmax(axis=0), NO_ROW)
    row[open_tracks] = np.where(by_overlap == NO_ROW, _nearest_inside(frame_truth.boxes_ego, boxes), by_overlap)
    return row


def _nearest_inside(actors: Floats, boxes: Floats) -> Ints:
    """(T,) row of the actor (A, 5) whose centre is inside a box (T, 5) and nearest to its centre, `NO_ROW` for none."""
    offset = np.abs(turned(actors[:, :2] - boxes[:, None, :2], -boxes[:, None, 2]))  # (T, A, 2)
    inside: Bools = np.asarray((offset <= 0.5 * boxes[:, None, 3:]).all(axis=2))
    nearest = np.where(inside, np.hypot(offset[..., 0], offset[..., 1]), np.inf).argmin(axis=1)
    return np.where(inside.any(axis=1), nearest, NO_ROW)

"""Tracks of one frame matched with the actors: followed actor, verdict, overlap and heading error of each track."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.grading import frame_tables, mma_metrics
from luxloop.scenarios.grading.frame_truth import IS_VULNERABLE, FrameTruth
from luxloop.scenarios.grading.matching import NO_TRACK, TrackMatcher, TrackVerdict
from luxloop.scenarios.grading.plane_geometry import into_frame, iou_table, out_of_frame, turned, wrap
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import MODEL_NAMES, MODELS, Status, Tracks

VELOCITY, ACCELERATION, HEADING = 2, 4, 6
"""First columns of velocity and acceleration, and column of the heading, in `Tracks.mean`."""
MODEL_COLUMNS = frame_tables.model_columns(MODELS).keys()
"""Columns that every table of tracks has."""


def track_boxes(tracks: Tracks, ego_pose_odom: Floats) -> Floats:
    """Return the boxes (T, 5) of the tracks in the ego frame.

    The transform uses the ego pose in the odometry frame that the tracker received, so odometry drift does not count as
    an error of the tracker.
    """
    heading = tracks.mean[:, HEADING]
    center = tracks.mean[:, :2] - turned(0.5 * tracks.corner_sign * tracks.size, heading)
    return np.column_stack([into_frame(np.column_stack([center, heading]), ego_pose_odom), tracks.size])


def selected_model(tracks: Tracks) -> Ints:
    """(T,) index in `MODEL_NAMES` of the selected models; -1 for unknown ones."""
    index = np.array([MODEL_NAMES.index(name) for name in tracks.models], dtype=np.int64)
    return np.where(tracks.model >= 0, index[tracks.model], -1)


@dataclass(frozen=True, slots=True, eq=False)
class TrackMatches:
    """T tracks matched with A actors in one frame."""

    boxes_ego: Floats
    """(T, 5) boxes of the tracks in the ego frame."""
    actor_row: Ints
    """(T,) row of the actor that each track follows; -1 for none, and for tracks that are not reported."""
    verdict: npt.NDArray[np.int8]
    """(T,) `TrackVerdict`."""
    overlap: Floats
    """(A, T) intersection over union; 0 for tracks that are not reported."""
    heading_error: Floats
    """(T,) heading of the track minus truth in (-pi, pi] [rad]; NaN for tracks that follow no actor."""

    @classmethod
    def of(cls, frame_truth: FrameTruth, tracks: Tracks, matcher: TrackMatcher) -> "TrackMatches":
        """Match the reported tracks with the actors. Only confirmed tracks count as reported, coasting ones do not."""
        boxes = track_boxes(tracks, frame_truth.scan.ego_pose_odom)
        reported = np.flatnonzero(tracks.status == Status.CONFIRMED)
        overlap = np.zeros((len(frame_truth.actors), len(tracks)))
        overlap[:, reported] = frame_truth.overlap(boxes[reported])
        matching = matcher.match(
            frame_truth.actors.id,
            overlap[:, reported],
            frame_truth.graded,
            tracks.id[reported],
            boxes[reported],
            parted=frame_truth.bent,
        )
        actor_row = np.full(len(tracks), -1, dtype=np.int64)
        actor_row[reported] = matching.actor_row
        verdict = np.full(len(tracks), TrackVerdict.UNREPORTED, dtype=np.int8)
        verdict[reported] = matching.verdict
        verdict[_small_on_nothing(frame_truth, tracks, verdict, overlap)] = TrackVerdict.UNGRADED
        verdict[_on_ghosts(boxes, verdict, frame_truth.ghosts_ego, matcher.iou_min)] = TrackVerdict.UNGRADED
        error = np.full(len(tracks), np.nan)
        pair = np.flatnonzero(actor_row >= 0)
        error[pair] = wrap(boxes[pair, 2] - frame_truth.boxes_ego[actor_row[pair], 2])
        return cls(boxes, actor_row, verdict, overlap, error)

    def actor_id(self, frame_truth: FrameTruth) -> Ints:
        """(T,) id of the actor that each track follows, or `NO_ACTOR`."""
        return np.append(frame_truth.actors.id, NO_ACTOR)[self.actor_row]

    def track_of_actor(self, frame_truth: FrameTruth, tracks: Tracks) -> Ints:
        """(A,) id of the track that follows each actor, or `NO_TRACK`."""
        out = np.full(len(frame_truth.actors), NO_TRACK, dtype=np.int64)
        pair = np.flatnonzero(self.actor_row >= 0)
        out[self.actor_row[pair]] = tracks.id[pair]
        return out

    def rows(self, frame_truth: FrameTruth, tracks: Tracks) -> dict[str, npt.NDArray[Any]]:
        """Return the rows of the track table."""
        x, y, yaw = out_of_frame(self.boxes_ego[:, :3], frame_truth.frame.ego.pose_world).T
        judged = (self.verdict == TrackVerdict.GRADED) & ~np.append(frame_truth.bent, False)[self.actor_row]
        row = np.flatnonzero(judged)
        true_boxes = frame_truth.boxes_ego[self.actor_row[row]]
        pair = np.flatnonzero(self.actor_row >= 0)
        iou = np.full(len(tracks), np.nan)
        iou[pair] = self.overlap[self.actor_row[pair], pair]
        ego_pose_odom = frame_truth.scan.ego_pose_odom
        odom_to_world = frame_truth.frame.ego.pose_world[2] - ego_pose_odom[2]
        columns: dict[str, npt.NDArray[Any]] = {
            "track_id": tracks.id,
            "status": tracks.status,
            "x_world_m": x,
            "y_world_m": y,
            "yaw_world_rad": yaw,
            "length_m": tracks.size[:, 0],
            "width_m": tracks.size[:, 1],
            "range_m": np.hypot(self.boxes_ego[:, 0], self.boxes_ego[:, 1]),
            **_motion(tracks, odom_to_world),
            "model": selected_model(tracks),
            **{f"probability_{model}": tracks.model_probability[:, m] for m, model in enumerate(tracks.models)},
            "verdict": self.verdict,
            "actor_id": self.actor_id(frame_truth),
            "true_mode": np.append(frame_truth.actors.mode.astype(np.int8), -1)[self.actor_row],
            "iou": iou,
            "heading_error_deg": np.degrees(self.heading_error),
            "judged": judged,
            "label": np.full(len(tracks), -1) if tracks.small is None else tracks.small.astype(np.int64),
            **mma_metrics.corner_errors(tracks, row, self.boxes_ego[row], true_boxes, ego_pose_odom),
            **mma_metrics.predicted(tracks, row, ego_pose_odom, frame_truth.frame.ego.pose_world),
        }
        unused = MODEL_COLUMNS - columns.keys()
        return columns | dict.fromkeys(unused, np.full(len(tracks), np.nan))

    def overlap_rows(self, frame_truth: FrameTruth, tracks: Tracks) -> dict[str, npt.NDArray[Any]]:
        """Return the rows of the overlap table."""
        actor, track = np.nonzero(self.overlap)
        return {
            "actor_id": frame_truth.actors.id[actor],
            "track_id": tracks.id[track],
            "iou": self.overlap[actor, track],
        }


def _small_on_nothing(frame_truth: FrameTruth, tracks: Tracks, verdict: npt.NDArray[np.int8], overlap: Floats) -> Ints:
    """Return the false tracks of small road users that overlap no vehicle and no obstacle: no vehicle is claimed."""
    if tracks.small is None or not len(tracks):
        return np.empty(0, np.int64)
    others = ~IS_VULNERABLE[frame_truth.actors.kind]
    nothing = overlap[others].max(axis=0, initial=0.0) == 0.0
    return np.flatnonzero(tracks.small & nothing & (verdict == TrackVerdict.FALSE))


def _on_ghosts(boxes: Floats, verdict: npt.NDArray[np.int8], ghosts: Floats, iou_min: float) -> Ints:
    """Return the false tracks that are where an actor vanished in view: a tracker cannot know it yet."""
    false = np.flatnonzero(verdict == TrackVerdict.FALSE)
    if not len(ghosts) or not len(false):
        return np.empty(0, np.int64)
    on: Ints = false[iou_table(boxes[false], ghosts).max(axis=1) >= iou_min]
    return on


def _motion(tracks: Tracks, odom_to_world: float) -> dict[str, npt.NDArray[Any]]:
    """Return velocity and acceleration as columns of the track table, turned by `odom_to_world` [rad]."""
    velocity, acceleration = (turned(tracks.mean[:, k : k + 2], odom_to_world) for k in (VELOCITY, ACCELERATION))
    return {
        "vx_world_mps": velocity[:, 0],
        "vy_world_mps": velocity[:, 1],
        "ax_world_mps2": acceleration[:, 0],
        "ay_world_mps2": acceleration[:, 1],
    }

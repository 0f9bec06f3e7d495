"""One frame's tracks held against its actors: whom each follows, what that is worth, and how far off it is."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenarios.arrays import Floats, Ints
from scenarios.grading import mma_metrics
from scenarios.grading.frame_truth import Instant
from scenarios.grading.matching import NO_TRACK, Pairer, TrackVerdict
from scenarios.grading.plane_geometry import into_frame, out_of_frame, turned, wrap
from sensor_model.truth import NO_ACTOR
from tracker.records import MODELS, Status, Tracks

HEADING = 6
"""Place of the heading in `Tracks.mean`."""


def track_boxes(tracks: Tracks, ego_pose_odom: Floats) -> Floats:
    """(T, 5) boxes of the tracks in the ego frame.

    Odometry is undone with the pose that the tracker was given, so that its drift is not charged to the tracker.
    """
    heading = tracks.mean[:, HEADING]
    center = tracks.mean[:, :2] - turned(0.5 * tracks.corner_sign * tracks.size, heading)
    return np.column_stack([into_frame(np.column_stack([center, heading]), ego_pose_odom), tracks.size])


@dataclass(frozen=True, slots=True, eq=False)
class Following:
    """T tracks against A actors in one frame."""

    boxes_ego: Floats
    """(T, 5)."""
    actor_row: Ints
    """(T,) row of the actor each track follows, -1 for none; tracks that are not reported follow nobody."""
    verdict: npt.NDArray[np.int8]
    """(T,) `TrackVerdict`."""
    overlap: Floats
    """(A, T) intersection over union; 0 for tracks that are not reported."""
    heading_error: Floats
    """(T,) track minus truth in (-pi, pi], NaN where a track follows nobody."""

    @classmethod
    def of(cls, now: Instant, tracks: Tracks, pairer: Pairer) -> "Following":
        """Pair the reported tracks with the actors: the confirmed ones. A coasting track is a guess, not a report."""
        boxes = track_boxes(tracks, now.scan.ego_pose_odom)
        reported = np.flatnonzero(tracks.status == Status.CONFIRMED)
        overlap = np.zeros((len(now.actors), len(tracks)))
        overlap[:, reported] = now.overlap(boxes[reported])
        pairing = pairer.pair(now.actors.id, overlap[:, reported], now.graded, tracks.id[reported], boxes[reported])
        actor_row = np.full(len(tracks), -1, dtype=np.int64)
        actor_row[reported] = pairing.actor_row
        verdict = np.full(len(tracks), TrackVerdict.UNREPORTED, dtype=np.int8)
        verdict[reported] = pairing.verdict
        error = np.full(len(tracks), np.nan)
        pair = np.flatnonzero(actor_row >= 0)
        error[pair] = wrap(boxes[pair, 2] - now.boxes_ego[actor_row[pair], 2])
        return cls(boxes, actor_row, verdict, overlap, error)

    def actor_id(self, now: Instant) -> Ints:
        """(T,) id of the actor each track follows."""
        return np.append(now.actors.id, NO_ACTOR)[self.actor_row]

    def track_of_actor(self, now: Instant, tracks: Tracks) -> Ints:
        """(A,) id of the track that follows each actor."""
        out = np.full(len(now.actors), NO_TRACK, dtype=np.int64)
        pair = np.flatnonzero(self.actor_row >= 0)
        out[self.actor_row[pair]] = tracks.id[pair]
        return out

    def rows(self, now: Instant, tracks: Tracks) -> dict[str, npt.NDArray[Any]]:
        """Rows of the track table."""
        x, y, yaw = out_of_frame(self.boxes_ego[:, :3], now.frame.ego.pose_world).T
        judged = self.verdict == TrackVerdict.GRADED
        row = np.flatnonzero(judged)
        true_boxes = now.boxes_ego[self.actor_row[row]]
        pair = np.flatnonzero(self.actor_row >= 0)
        iou = np.full(len(tracks), np.nan)
        iou[pair] = self.overlap[self.actor_row[pair], pair]
        return {
            "track_id": tracks.id,
            "status": tracks.status,
            "x_world_m": x,
            "y_world_m": y,
            "yaw_world_rad": yaw,
            "length_m": tracks.size[:, 0],
            "width_m": tracks.size[:, 1],
            "model": tracks.model,
            **{f"probability_{model}": tracks.model_probability[:, m] for m, model in enumerate(MODELS)},
            "verdict": self.verdict,
            "actor_id": self.actor_id(now),
            "true_mode": np.append(now.actors.mode.astype(np.int8), -1)[self.actor_row],
            "iou": iou,
            "heading_error_deg": np.degrees(self.heading_error),
            "judged": judged,
            **mma_metrics.corner_errors(tracks, row, self.boxes_ego[row], true_boxes, now.scan.ego_pose_odom),
        }

    def overlap_rows(self, now: Instant, tracks: Tracks) -> dict[str, npt.NDArray[Any]]:
        """Rows of the overlap table."""
        actor, track = np.nonzero(self.overlap)
        return {
            "actor_id": now.actors.id[actor],
            "track_id": tracks.id[track],
            "iou": self.overlap[actor, track],
        }

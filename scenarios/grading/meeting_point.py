"""Meeting point of the ego's and an actor's paths, as driven in a run."""

from typing import NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Floats

NO_MEETING = (np.nan, np.nan)

AHEAD_S = 1.0
"""[s] Continuation of an actor's path, which ends with the run, perhaps in front of the ego."""


class EgoPath(NamedTuple):
    """Path of the ego's front over F frames."""

    time_s: Floats
    """(F,) [s]."""
    front: Floats
    """(F, 2) middle of the front in the world frame [m]."""
    along_m: Floats
    """(F,) distance driven by the front since the first frame [m]."""
    width_m: float

    @classmethod
    def of(cls, time_s: Floats, boxes: Floats) -> "EgoPath":
        """Return the path of boxes (F, 5): x, y, yaw, length, width."""
        heading = np.column_stack([np.cos(boxes[:, 2]), np.sin(boxes[:, 2])])
        front = boxes[:, :2] + 0.5 * boxes[:, 3:4] * heading
        steps = np.hypot(*np.diff(front, axis=0, prepend=front[:1]).T)
        return cls(time_s, front, np.cumsum(steps), float(boxes[0, 4]))

    def meeting(self, boxes: Floats, last_mps: float) -> tuple[float, float]:
        """Return time [s] and distance driven [m] at which the front is at the meeting point with an actor.

        The meeting point is the first point of the front's path that is not farther from the actor's path than half the
        sum of both widths, whenever the actor is there. The actor's path begins at its rear in the first frame and ends
        at its front in the last, moved straight ahead by `AHEAD_S` at its last speed. There is no meeting point (NaN,
        NaN) if the paths do not come so close, or are so close from the first frame on.

        Parameters
        ----------
        boxes
            (K, 5) boxes of the actor in time order.
        last_mps
            Its last speed [m/s].
        """
        reach = 0.5 * (self.width_m + boxes[0, 4])
        distance_m = _distances(_path(boxes, AHEAD_S * last_mps), self.front)
        near = np.flatnonzero(distance_m <= reach)
        if not len(near) or near[0] == 0:
            return NO_MEETING
        frames = near[0] + np.array([-1, 0])
        before, after = distance_m[frames]
        share = (before - reach) / (before - after)
        time_s, along_m = (column[frames] @ (1.0 - share, share) for column in (self.time_s, self.along_m))
        return float(time_s), float(along_m)


def _path(boxes: Floats, ahead_m: float) -> Floats:
    """(K + 2, 2) centre's path of boxes (K, 5), from the rear of the first to the front of the last and farther."""
    heading = np.column_stack([np.cos(boxes[:, 2]), np.sin(boxes[:, 2])])
    half_m = 0.5 * boxes[0, 3]
    rear, front = boxes[0, :2] - half_m * heading[0], boxes[-1, :2] + (half_m + ahead_m) * heading[-1]
    return np.vstack([rear, boxes[:, :2], front])


def _distances(path: Floats, points: Floats) -> Floats:
    """(N,) distances of points (N, 2) from a polyline (K, 2) [m]."""
    step = np.diff(path, axis=0)
    length_squared = np.sum(step**2, axis=1)
    offset = points[:, None] - path[:-1]
    along = np.sum(offset * step, axis=2)
    share = np.divide(along, length_squared, np.zeros_like(along), where=length_squared > 0.0)  # a standing actor
    apart = offset - np.clip(share, 0.0, 1.0)[..., None] * step
    return np.asarray(np.hypot(apart[..., 0], apart[..., 1]).min(axis=1))

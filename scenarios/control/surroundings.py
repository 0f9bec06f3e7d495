"""Input of the controller: ego motion and surrounding objects, from odometry and tracks or from the ground truth."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.articulated import parts
from luxloop.scenarios.grading.plane_geometry import into_frame, turned, wrap
from luxloop.scenarios.grading.track_matches import track_boxes
from luxloop.sim.world import Ego, WorldFrame
from luxloop.tracker.records import Status, Tracks
from luxloop.tracker.scan import Scan

_VELOCITY = slice(2, 4)
"""Components of the velocity in `Tracks.mean`."""


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """Ego motion, and N objects in the ego frame."""

    speed: float
    """[m/s] Speed of the ego along its heading, negative backwards."""
    yaw_rate: float
    """[rad/s] Yaw rate of the ego."""
    front_m: float
    """[m] Distance from the ego's centre to its front bumper."""
    id: Ints
    """(N,) id of the track or the actor; an articulated truck has two boxes."""
    boxes_ego: Floats
    """(N, 5) x, y [m], yaw [rad], length, width [m]."""
    velocity_ego: Floats
    """(N, 2) velocity over ground [m/s], on the ego's axes."""


class TrackedSurroundings:
    """Surroundings from the confirmed tracks; coasting tracks are predictions and are ignored.

    A track without a velocity is taken to stand, which makes the ego brake.

    Parameters
    ----------
    dt
        Time between frames [s].
    """

    def __init__(self, dt: float):
        self._dt = dt
        self._last_pose_odom: Floats | None = None

    def observe(self, ego: Ego, scan: Scan, tracks: Tracks) -> Surroundings | None:
        """Return the surroundings; None at the first scan, since a speed needs two poses.

        Only the size of `ego` is used.
        """
        last, now = self._last_pose_odom, scan.ego_pose_odom
        self._last_pose_odom = now
        if last is None:
            return None
        change = wrap(now[2] - last[2])
        step = turned(now[:2] - last[:2], -(last[2] + 0.5 * change))
        row = np.flatnonzero(tracks.status == Status.CONFIRMED)
        return Surroundings(
            speed=float(step[0]) / self._dt,
            yaw_rate=float(change) / self._dt,
            front_m=0.5 * float(ego.size[0]),
            id=tracks.id[row],
            boxes_ego=track_boxes(tracks, now)[row],
            velocity_ego=turned(np.nan_to_num(tracks.mean[row, _VELOCITY]), -now[2]),
        )


def true_surroundings(frame: WorldFrame) -> Surroundings:
    """Return the surroundings from the ground truth."""
    ego, actors = frame.ego, frame.actors
    row, pose_world, size = parts(actors.pose_world, actors.size[:, :2], actors.joint_angles, actors.kind)
    return Surroundings(
        speed=float(turned(ego.velocity_world, -ego.pose_world[2])[0]),
        yaw_rate=ego.yaw_rate,
        front_m=0.5 * float(ego.size[0]),
        id=actors.id[row],
        boxes_ego=np.column_stack([into_frame(pose_world, ego.pose_world), size]),
        velocity_ego=turned(actors.velocity_world[row], -ego.pose_world[2]),
    )

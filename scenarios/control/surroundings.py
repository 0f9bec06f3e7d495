"""Input of the controller: ego motion and surrounding objects, from odometry and tracks or from the ground truth."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.articulated import parts
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner, into_frame, turned, wrap
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


_MIN_SPEED = 1.0
"""[m/s] Lower bound of the speed in curvature = yaw rate / speed, which is undefined at standstill."""
_STRAIGHT = 1e-6
"""[1/m] Curvature below which the path is taken as straight."""


@dataclass(frozen=True, slots=True)
class LeadVehicle:
    """The lead vehicle."""

    id: int
    """Id of its track, or of the actor."""
    gap: float
    """[m] Gap along the path, from the ego's front bumper to its nearest point in the corridor; negative in a crash."""
    speed: float
    """[m/s] Speed along the path."""


def find_lead(around: Surroundings, half_width_m: float) -> LeadVehicle | None:
    """Return the lead vehicle in a corridor of this half width [m], or None.

    Only objects whose centre is in front of the ego's centre are considered.
    """
    curvature = around.yaw_rate / max(abs(around.speed), _MIN_SPEED)
    center = to_path_frame(around.boxes_ego[:, :2], curvature)
    corners = to_path_frame(corner(around.boxes_ego[:, None], CORNER_SIGNS), curvature)
    near = np.where(center[:, 0] > 0, nearest_in_corridor(corners, half_width_m), np.inf)
    if not np.isfinite(near).any():
        return None
    row = int(np.argmin(near))
    path_heading = curvature * center[row, 0]
    speed = float(around.velocity_ego[row] @ (np.cos(path_heading), np.sin(path_heading)))
    return LeadVehicle(int(around.id[row]), float(near[row]) - around.front_m, speed)


def to_path_frame(points_ego: Floats, curvature: float) -> Floats:
    """Return points (..., 2) [m] as (arc length along the path, offset to its left) from the ego's centre.

    The path is an arc of constant curvature k [1/m], positive to the left. A point with arc length s and offset d is at
    x = sin(k s) (1/k - d), y = 1/k - cos(k s) (1/k - d).
    """
    if abs(curvature) < _STRAIGHT:
        return points_ego
    sine, cosine = curvature * points_ego[..., 0], 1.0 - curvature * points_ego[..., 1]
    return np.stack([np.arctan2(sine, cosine), 1.0 - np.hypot(sine, cosine)], axis=-1) / curvature


def nearest_in_corridor(corners: Floats, half_width_m: float) -> Floats:
    """Return the smallest arc length (N,) of outlines (N, 4, 2) inside the corridor; infinite for those outside.

    The minimum is at a corner inside the corridor, or where an edge crosses one of its borders.
    """
    after = np.roll(corners, -1, axis=1)
    arc, offset = corners[..., 0], corners[..., 1]
    at = [np.where(np.abs(offset) <= half_width_m, arc, np.inf)]
    rise = after[..., 1] - offset
    for border in (-half_width_m, half_width_m):
        part = (border - offset) / np.where(rise == 0, np.nan, rise)
        crosses = (part >= 0) & (part <= 1)
        at.append(np.where(crosses, arc + np.where(crosses, part, 0.0) * (after[..., 0] - arc), np.inf))
    return np.asarray(np.min(at, axis=(0, 2)))

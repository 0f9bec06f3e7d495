"""Deskew: move the points of a sweep to the positions of their objects at the scan's time.

A point is measured in the ego frame at the time of its beam. Odometry compensates for ego motion until the scan's time;
the motion of the object is known from its track only. Both are needed: two units that meet 30 degrees off their axes
measure the car ahead 13 ms apart. If it keeps its distance, the raw points agree; ego motion compensation alone, at
25 m/s, makes two rears 0.3 m apart.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Floats32, Ints
from luxloop.compiled import kernel
from luxloop.tracker.detection.point_groups import means
from luxloop.tracker.geometry import rotate, wrap
from luxloop.tracker.kernels import inside, placed
from luxloop.tracker.records import NO_TRACK, OrientedBoxes, SegmentedPoints
from luxloop.tracker.scan import Scan

MARGIN_M = 0.5
"""Margin around a track's box for the centre of its points [m]: points are on its sides."""


@dataclass(frozen=True, slots=True)
class DeskewConfig:
    """Motion that is compensated during the sweep."""

    motion: Literal["none", "ego", "all"] = "all"
    """`none`: raw points, for scans that are compensated already. `ego`: ego motion only, as if all objects were
    stationary. `all`: ego and track motion. Change it to measure the effect of the sweep, or for such scans."""


class EgoMotion:
    """Ego motion compensation by the poses of the last two scans."""

    def __init__(self, config: DeskewConfig) -> None:
        self._config = config
        self._last: tuple[float, Floats] | None = None

    def undo(self, scan: Scan) -> Scan:
        """Return the scan with its points in the ego frame at the scan's time. The first scan is returned unchanged.

        Time offsets are kept only if the motion of targets remains to be compensated.
        """
        last, self._last = self._last, (scan.time, scan.ego_pose_odom)
        points, tau = scan.points_ego, scan.time_offset
        if self._config.motion != "none" and last is not None and scan.time > last[0]:
            points = moved(points, tau.astype(np.float64), *twist(last[1], scan.ego_pose_odom, scan.time - last[0]))
        return replace(scan, points_ego=points, time_offset=tau if self._config.motion == "all" else 0 * tau)


def twist(then: Floats, now: Floats, dt: float) -> tuple[Floats, float]:
    """Return the velocity (2,) [m/s] in the body frame and yaw rate [rad/s] between two poses (3,) `dt` [s] apart.

    A body with constant velocity in its own frame moves on an arc. The chord is at half the turn x from its heading,
    and shorter than the arc by the factor sin(x) / x.
    """
    turn = wrap(float(now[2] - then[2]))
    chord = rotate(now[:2] - then[:2], -(then[2] + 0.5 * turn))
    return chord / (dt * np.sinc(0.5 * turn / np.pi)), turn / dt


def moved(points: Floats32, tau: Floats, velocity: Floats, yaw_rate: float) -> Floats32:
    """(N, 3) points measured `tau` (N,) [s] later by a body with that twist, in its current frame [m]."""
    still = without_ego_motion(np.asarray(points, dtype=np.float64, order="C"), tau, velocity, yaw_rate)
    return still.astype(points.dtype)


def undo_targets(points: SegmentedPoints, ego_pose_odom: Floats, movers: OrientedBoxes) -> SegmentedPoints:
    """Return the points with those of each track moved to the scan's time, without time offsets.

    A segment whose centre lies in the box of a track moves with that track; other points keep position and time offset.
    Positions are rounded to float32, as those of a scan are.
    """
    if not len(movers) or not points.segments.count:
        return points
    pose, label = np.asarray(ego_pose_odom, dtype=np.float64), points.label
    owner = _owner(placed(means(points.xy, label, points.segments.count), pose), movers)
    mover = owner[label]
    still = without_motion(points.xy, points.time_offset, mover, rotate(movers.velocity, -ego_pose_odom[2]))
    left = np.where(mover == NO_TRACK, points.time_offset, 0.0)
    return replace(points, xy=still.astype(np.float32).astype(np.float64), time_offset=left)


def _owner(middle: Floats, movers: OrientedBoxes) -> Ints:
    """(S,) track whose box contains each centre (S, 2), the nearest of several, `NO_TRACK` for none."""
    held = inside(middle, movers.center, movers.heading, movers.size + 2 * MARGIN_M)
    x, y = (middle[:, None, axis] - movers.center[:, axis] for axis in (0, 1))
    nearest = np.where(held, x * x + y * y, np.inf).argmin(axis=1)
    return np.where(held.any(axis=1), nearest, NO_TRACK)


@kernel()
def without_ego_motion(points: Floats, tau: Floats, velocity: Floats, yaw_rate: float) -> Floats:
    """(N, 3) points measured `tau` (N,) [s] later by a body with that twist, in its current frame [m]."""
    still = np.empty((len(points), 3))
    for i in range(len(points)):
        half, x, y = 0.5 * yaw_rate * tau[i], points[i, 0], points[i, 1]
        cos, sin = elementary.cos(half), elementary.sin(half)
        chord = 2.0 * sin / yaw_rate if yaw_rate != 0.0 else tau[i]
        # Rotate by half the angle, move along the chord, and rotate by the other half.
        x, y = cos * x - sin * y + chord * velocity[0], sin * x + cos * y + chord * velocity[1]
        still[i, 0], still[i, 1], still[i, 2] = cos * x - sin * y, sin * x + cos * y, points[i, 2]
    return still


@kernel()
def without_motion(points: Floats, tau: Floats, mover: Ints, velocity: Floats) -> Floats:
    """(N, 2) points without the motion in `tau` (N,) [s] of their movers (N,), -1 for none, with velocities (T, 2)."""
    still = points.copy()
    for i in range(len(points)):
        if mover[i] >= 0:
            for axis in range(2):
                still[i, axis] = points[i, axis] - velocity[mover[i], axis] * tau[i]
    return still

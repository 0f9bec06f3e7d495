"""A sweep takes time: points are moved to where their things are at the scan's time.

A point comes in the vehicle's frame of the moment when its beam was fired. Until the scan's time the ego moves, which
odometry tells; the thing may move too, which only a track of it can tell. Traffic ahead shows why the one needs the
other: two units that meet there at 30 degrees off their axes fire at the car 13 ms apart. It keeps its distance, so
that the points agree as they come; moved by the ego's 25 m/s alone, they show two rears 0.3 m apart.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tracker.arrays import Floats, Floats32, Ints
from tracker.geometry import inside, rotate, wrap
from tracker.records import Segments
from tracker.scan import Scan

NOBODY = -1


@dataclass(frozen=True, slots=True)
class DeskewConfig:
    """Whose motion during the sweep is made up for."""

    motion: Literal["none", "ego", "all"] = "all"
    """`none`: points are taken as they come. `ego`: the ego's alone, as if all others stood. `all`: the tracks' too."""
    margin_m: float = 0.5
    """How far outside a track's box the middle of its points may lie [m]: points are on its sides."""


@dataclass(frozen=True, slots=True, eq=False)
class Movers:
    """T tracks as predicted for the scan's time, in the odometry frame."""

    center: Floats
    """(T, 2) [m]."""
    heading: Floats
    """(T,)."""
    size: Floats
    """(T, 2) length, width [m]."""
    velocity: Floats
    """(T, 2) [m/s]."""


class EgoMotion:
    """Knows from the last two scans how the ego moves."""

    def __init__(self, config: DeskewConfig) -> None:
        self._config = config
        self._last: tuple[float, Floats] | None = None

    def undo(self, scan: Scan) -> Scan:
        """Return the scan with its points as from the ego frame at the scan's time. The first comes as it is.

        Time offsets are left only where the motion of the targets is still to be made up for.
        """
        last, self._last = self._last, (scan.time, scan.ego_pose_odom)
        points, tau = scan.points_ego, scan.time_offset
        if self._config.motion != "none" and last is not None and scan.time > last[0]:
            points = moved(points, tau.astype(np.float64), *twist(last[1], scan.ego_pose_odom, scan.time - last[0]))
        return replace(scan, points_ego=points, time_offset=tau if self._config.motion == "all" else 0 * tau)


def twist(then: Floats, now: Floats, dt: float) -> tuple[Floats, float]:
    """Velocity (2,) [m/s] in the body's frame and yaw rate [rad/s] that lead in `dt` [s] from one pose (3,) to another.

    A body whose velocity is constant in its own frame runs on an arc. Half the turn lies between its heading and the
    chord, which is shorter than the way by sin(x) / x, x being half the turn.
    """
    turn = wrap(float(now[2] - then[2]))
    chord = rotate(now[:2] - then[:2], -(then[2] + 0.5 * turn))
    return chord / (dt * np.sinc(0.5 * turn / np.pi)), turn / dt


def moved(points: Floats32, tau: Floats, velocity: Floats, yaw_rate: float) -> Floats32:
    """(N, 3) points that a body of that twist sees `tau` (N,) later [s], in its frame of now."""
    half = 0.5 * yaw_rate * tau
    cos, sin = np.cos(half), np.sin(half)
    chord = 2.0 * sin / yaw_rate if yaw_rate else tau
    # turned by half the angle, moved along the chord, which lies there, and turned by the other half
    x = cos * points[:, 0] - sin * points[:, 1] + chord * velocity[0]
    y = sin * points[:, 0] + cos * points[:, 1] + chord * velocity[1]
    still = points.copy()
    still[:, 0], still[:, 1] = cos * x - sin * y, sin * x + cos * y
    return still


def undo_targets(scan: Scan, segments: Segments, movers: Movers, config: DeskewConfig) -> Scan:
    """Return the scan with the points of each track where they are at the scan's time, and no time offset left.

    A segment whose middle lies in a track's box moves with that track; all other points keep place and time offset.
    """
    if not len(movers.heading) or not segments.count:
        return scan
    middle = _middle(scan.points_ego, segments)
    owner = _owner(rotate(middle, scan.ego_pose_odom[2]) + scan.ego_pose_odom[:2], movers, config)
    mover = np.append(owner, NOBODY)[segments.label]  # the label of points in no segment is -1
    followed = np.flatnonzero(mover != NOBODY)
    way = rotate(movers.velocity, -scan.ego_pose_odom[2])[mover[followed]] * scan.time_offset[followed, None]
    points, tau = scan.points_ego.copy(), scan.time_offset.copy()
    points[followed, :2] -= way
    tau[followed] = 0.0
    return replace(scan, points_ego=points, time_offset=tau)


def _middle(points: Floats32, segments: Segments) -> Floats:
    """(S, 2) mean of each segment's points."""
    bins = segments.label + 1
    x, y, size = (np.bincount(bins, weights=weights)[1:] for weights in (points[:, 0], points[:, 1], None))
    return np.stack([x, y], axis=1) / size[:, None]


def _owner(middle: Floats, movers: Movers, config: DeskewConfig) -> Ints:
    """(S,) the track in whose box each middle (S, 2) lies, the nearest if there are several, `NOBODY` if none."""
    held = inside(middle, movers.center, movers.heading, movers.size + 2 * config.margin_m)
    x, y = (middle[:, None, axis] - movers.center[:, axis] for axis in (0, 1))
    nearest = np.where(held, x * x + y * y, np.inf).argmin(axis=1)
    return np.where(held.any(axis=1), nearest, NOBODY)

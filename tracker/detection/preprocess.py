"""Preprocessing: drop points on the ground, on the ego, out of range, or flagged by the unit."""

import math
from dataclasses import dataclass, replace

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.detection.point_groups import any_within, positions
from luxloop.tracker.scan import PointFlag, Scan

OWN_MARGIN_M = 0.1
"""Margin around the ego's body [m]."""


@dataclass(frozen=True, slots=True)
class PreprocessConfig:
    """Limits of the points to keep."""

    drop_flags: tuple[str, ...] = ("clutter", "ground", "dirt")
    """Names of `PointFlag`: points with any of them are dropped. Change it if your driver sets a flag otherwise: a
    common one (AutonomouStuff ibeo_core) drops "transparent" points, too, but that flag only means another echo behind.
    Bumpers have it where the beam also hits the rear window, edges where there is a wall behind the vehicle."""
    first_echo_only: bool = False
    """Drop second and third echoes. Set it for units whose later echoes are unreliable. Off: behind a raindrop or the
    ground, the second echo is the vehicle."""
    inside_depth_m: float = 3.0
    """A later echo at most this far behind another echo of its beam, and no wider, is dropped [m]: it is inside the
    same vehicle, or from its glass over the hood. A wider echo is a vehicle behind spray. Set 0, which keeps all, to
    compare with the paper."""
    ground_z_max_m: float = 0.15
    """Lower points without a higher one near are ground [m]. This is the ground clearance of a car; the lowest layer,
    1.2 degrees down and mounted at 0.8, reports ground echoes up to a quarter of its mounting height. Raise it on
    uneven ground."""
    upright_m: float = 0.3
    """Low points at most this far from a higher one are on an upright surface, not on the ground [m]: the ego's front
    rises when it accelerates, and points of a vehicle at 40 m then seem 0.6 m too low for 4 m/s^2. Faces of vehicles
    lean back by less than this between two layers. Set 0, which drops all low points, for units that never pitch."""
    range_max_m: float = 60.0
    """Maximum range from the ego's centre [m]. Raise it for units that see vehicles farther away."""
    own_length_m: float = 4.83
    """Length of the ego's body, centred on the ego frame [m]; points inside the body are dropped. Change it with the
    car."""
    own_width_m: float = 1.91
    """Width of the ego's body [m]. Change it with the car."""

    def __post_init__(self) -> None:
        unknown = [name for name in self.drop_flags if name.upper() not in PointFlag.__members__]
        if unknown:
            known = ", ".join(name.lower() for name in PointFlag.__members__)
            raise ValueError(f"drop_flags: {unknown[0]!r} is not a point flag; choose from {known}")
        if self.inside_depth_m < 0.0:
            raise ValueError(f"inside_depth_m is {self.inside_depth_m}; give a depth in metres, or 0 for none")
        if self.upright_m < 0.0:
            raise ValueError(f"upright_m is {self.upright_m}; give a distance in metres, or 0 to drop all low points")
        if self.range_max_m <= 0.0:
            raise ValueError(f"range_max_m is {self.range_max_m}; give a positive range in metres")


def keep(scan: Scan, config: PreprocessConfig) -> Bools:
    """(N,) mask of points to keep; points with a non-finite position or time are always dropped."""
    points = np.asarray(scan.points_ego, dtype=np.float64, order="C")
    kept = kept_points(
        points,
        np.asarray(scan.time_offset, dtype=np.float64),
        np.asarray(scan.flags, dtype=np.int64),
        sum(PointFlag[name.upper()] for name in set(config.drop_flags)),
        config.range_max_m,
        0.5 * np.array([config.own_length_m, config.own_width_m]) + OWN_MARGIN_M,
    )
    kept &= ~on_ground(points, kept, config.ground_z_max_m, config.upright_m)
    if config.first_echo_only:
        kept &= scan.echo == 0
    return kept & ~inside(scan, kept, config.inside_depth_m)


def on_ground(points: Floats, kept: Bools, z_max_m: float, upright_m: float) -> Bools:
    """(N,) mask of low points (N, 3) without a higher one near them, both of the `kept` (N,) points."""
    low = points[:, 2] < z_max_m
    found = kept & low
    if upright_m > 0.0:
        row, higher = np.flatnonzero(found), positions(points, np.flatnonzero(kept & ~low))
        found[row] = ~any_within(positions(points, row), higher, np.full(len(row), upright_m))
    return found


def masked(scan: Scan) -> Scan:
    """Return the scan with position and time 0 for non-finite points."""
    if np.isfinite(scan.points_ego).all() and np.isfinite(scan.time_offset).all():
        return scan
    whole = np.isfinite(scan.points_ego).all(axis=1) & np.isfinite(scan.time_offset)
    points, tau = np.where(whole[:, None], scan.points_ego, 0), np.where(whole, scan.time_offset, 0)
    return replace(scan, points_ego=points, time_offset=tau)


def inside(scan: Scan, kept: Bools, depth_m: float) -> Bools:
    """(N,) mask of echoes close behind a stronger one of the same beam, both of the `kept` (N,) points.

    Echoes of a beam are adjacent in the scan and have the same unit, layer and time. Stronger echoes are wider.
    """
    found = np.zeros(len(scan), dtype=np.bool_)
    later = np.flatnonzero(scan.echo[1:]) + 1
    behind = later[kept[later] & kept[later - 1]]
    for field in (scan.unit, scan.layer, scan.time_offset):
        behind = behind[field[behind] == field[behind - 1]]
    distance = np.linalg.norm(scan.points_ego[behind] - scan.points_ego[behind - 1], axis=1)
    weaker = scan.echo_pulse_width[behind] <= scan.echo_pulse_width[behind - 1]
    found[behind] = weaker & (distance <= depth_m)
    return found


@kernel()
def kept_points(points: Floats, time: Floats, flags: Ints, drop: int, range_max: float, half_size: Floats) -> Bools:
    """(N,) mask of points (N, 3) to keep: finite, without a flag of `drop`, and in range.

    Points within `half_size` (2,) of the origin along x and y are on the ego.
    """
    keep = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        keep[i] = (
            flags[i] & drop == 0
            and math.isfinite(z + time[i])
            and math.sqrt(x * x + y * y) <= range_max
            and (abs(x) > half_size[0] or abs(y) > half_size[1])
        )
    return keep

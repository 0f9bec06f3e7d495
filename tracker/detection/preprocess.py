"""Which points of a scan are worth fitting: off the ground, off the ego, near enough, and not disowned by the unit."""

from dataclasses import dataclass, replace

import numpy as np

from tracker.arrays import Bools
from tracker.scan import PointFlag, Scan


@dataclass(frozen=True, slots=True)
class PreprocessConfig:
    """Limits of what is kept."""

    drop_flags: tuple[str, ...] = ("clutter", "ground", "dirt")
    """Names of `PointFlag`: points that carry any of them are dropped. A common driver (AutonomouStuff ibeo_core) drops
    "transparent" ones too, but all the flag says is that the beam went on to something behind: a bumper has it wherever
    the same beam also meets the rear window, an edge wherever there is a wall behind the vehicle."""
    first_echo_only: bool = False
    """Drop second and third echoes. Off: behind a raindrop or the ground the second one is the vehicle."""
    inside_depth_m: float = 3.0
    """A later echo at most this far behind another of its beam, and no wider, is dropped [m]: it comes from inside the
    same vehicle, or from its glass over the hood. A wider one is a vehicle behind spray. 0 keeps all."""
    ground_z_max_m: float = 0.15
    """Lower points are ground [m]. A car's ground clearance, so nothing but tyres is lost; a level lowest layer,
    1.2 degrees down and 0.8 high, reports its ground echoes no higher than a quarter of its mounting height."""
    range_max_m: float = 60.0
    """Farther points are dropped [m], from the ego's centre."""
    own_length_m: float = 4.83
    """Length of the ego's body, centred on the ego frame: points in it are its own [m]."""
    own_width_m: float = 1.91
    """Its width [m]."""
    own_margin_m: float = 0.1
    """How far outside its body a point still is the ego's own [m]."""

    def __post_init__(self) -> None:
        unknown = [name for name in self.drop_flags if name.upper() not in PointFlag.__members__]
        if unknown:
            known = ", ".join(name.lower() for name in PointFlag.__members__)
            raise ValueError(f"drop_flags: {unknown[0]!r} is no point flag; choose from {known}")
        if self.inside_depth_m < 0.0:
            raise ValueError(f"inside_depth_m is {self.inside_depth_m}; give a depth in metres, or 0 for none")
        if self.range_max_m <= 0.0:
            raise ValueError(f"range_max_m is {self.range_max_m}; give a positive range in metres")


def keep(scan: Scan, config: PreprocessConfig) -> Bools:
    """(N,) whether each point takes part in the fitting; points whose place or time is not finite never do."""
    x, y, z = scan.points_ego.T
    drop = sum(PointFlag[name.upper()] for name in set(config.drop_flags))
    outside = (np.abs(x) > 0.5 * config.own_length_m + config.own_margin_m) | (
        np.abs(y) > 0.5 * config.own_width_m + config.own_margin_m
    )
    kept: Bools = (
        finite(scan)
        & (scan.flags & drop == 0)
        & (z >= config.ground_z_max_m)
        & (np.hypot(x, y) <= config.range_max_m)
        & outside
    )
    if config.first_echo_only:
        kept &= scan.echo == 0
    return kept & ~inside(scan, kept, config.inside_depth_m)


def finite(scan: Scan) -> Bools:
    """(N,) whether place and time of each point are finite."""
    return np.asarray(np.isfinite(scan.points_ego).all(axis=1) & np.isfinite(scan.time_offset))


def masked(scan: Scan) -> Scan:
    """Return the scan with 0 for place and time of points that are not finite, which nobody can compute with."""
    whole = finite(scan)
    if whole.all():
        return scan
    points, tau = np.where(whole[:, None], scan.points_ego, 0), np.where(whole, scan.time_offset, 0)
    return replace(scan, points_ego=points, time_offset=tau)


def inside(scan: Scan, kept: Bools, depth_m: float) -> Bools:
    """(N,) whether a point of the `kept` (N,) ones is an echo right behind a stronger one of them on the same beam.

    Echoes of a beam follow one another in the scan; they are known by unit, layer and time. The stronger an echo, the
    wider it is.
    """
    found = np.zeros(len(scan), dtype=np.bool_)
    behind = np.flatnonzero(kept[1:] & kept[:-1] & (scan.echo[1:] > 0)) + 1
    for field in (scan.unit, scan.layer, scan.time_offset):
        behind = behind[field[behind] == field[behind - 1]]
    distance = np.linalg.norm(scan.points_ego[behind] - scan.points_ego[behind - 1], axis=1)
    weaker = scan.echo_pulse_width[behind] <= scan.echo_pulse_width[behind - 1]
    found[behind] = weaker & (distance <= depth_m)
    return found

"""Which way a vehicle faces: a rectangle's heading is known modulo a quarter turn, a vehicle's must not flip."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import QUARTER, wrap


@dataclass(frozen=True, slots=True)
class OrientationConfig:
    """Choice among the four directions of a rectangle."""

    width_max_m: float = 2.6
    """A longer side is a vehicle's length [m]."""
    car_width_max_m: float = 2.1
    """A longer side is so, too, when more of it may be hidden [m]: it is more than a car's width."""
    depth_min_m: float = 1.5
    """With a shorter side at least as wide as a car, the longer one is the length [m]."""
    course_speed_min_mps: float = 1.0
    """A vehicle faces where it goes when it goes faster than this [m/s] ..."""
    course_sigma: float = 4.0
    """... and its speed is this many standard deviations from standing."""
    reversal_m: float = 0.5
    """Way that a vehicle goes backwards before its heading is reversed [m]."""
    sideways_m: float = 2.6
    """Way that it goes sideways before its heading is turned [m]: the edge of a standing vehicle that comes into view
    behind another seems to move, but no farther than the vehicle is wide."""
    votes: int = 5
    """Successive frames in which the size contradicts the heading of a vehicle without motion before it turns."""


def turn_sign(sign: Ints, quarters: int) -> Ints:
    """(2,) the same corner, named in a frame turned counter-clockwise by `quarters`."""
    x, y = sign
    return np.array([(x, y), (y, -x), (-x, -y), (-y, x)][quarters % 4], dtype=np.int64)


def turn_size(size: Floats, quarters: int) -> Floats:
    """(2,) the same sides, named in a frame turned by `quarters`."""
    return size[::-1].copy() if quarters % 2 else size


def first_guess(heading: float, size: Floats, whole: Bools, forward: float, config: OrientationConfig) -> int:
    """Quarter turns from a new box's heading to the vehicle's, whose sides (2,) [m] are seen as a `whole` (2,) or cut.

    The length lies along the longer side, unless only one short side is seen, which is then the width. Of the
    two directions left, the one nearer to the ego's own, `forward`, is taken until the vehicle moves.
    """
    longer = int(np.argmax(size))
    width_max = config.width_max_m if whole[longer] else config.car_width_max_m
    only_width = size.max() < width_max and size.min() < config.depth_min_m
    axis = heading + QUARTER * (longer != only_width)
    against = np.cos(axis - forward) < 0
    return int(longer != only_width) + 2 * int(against)


def course(velocity: Floats, covariance: Floats, config: OrientationConfig) -> float | None:
    """Direction of a velocity (2,) [m/s] of covariance (2, 2), None if it may as well be none."""
    significance = velocity @ np.linalg.solve(covariance, velocity)
    if np.hypot(*velocity) < config.course_speed_min_mps or significance < config.course_sigma**2:
        return None
    return float(np.arctan2(velocity[1], velocity[0]))


def by_course(heading: float, course: float) -> int:
    """Quarter turns by which the motion contradicts the heading: a vehicle faces its course."""
    return int(np.round(wrap(course - heading) / QUARTER)) % 4


def by_size(heading: float, size: Floats, whole: Bools, forward: float, config: OrientationConfig) -> int:
    """Quarter turns by which the seen size contradicts the heading: it tells length from width, not front from rear."""
    quarters = first_guess(heading, size, whole, forward, config)
    return quarters if quarters % 2 else 0


def way_needed(quarters: int, size: Floats, config: OrientationConfig) -> float:
    """Way [m] that a vehicle of seen size (2,) must go in contradiction to its heading before the heading gives in."""
    if quarters % 2 == 0:
        return config.reversal_m
    return np.inf if size[0] > config.width_max_m else config.sideways_m

"""Front of a vehicle: resolves the quarter-turn ambiguity of a rectangle's heading, without flips."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import QUARTER, wrap


@dataclass(frozen=True, slots=True)
class OrientationConfig:
    """Choice among the four directions of a rectangle."""

    width_max_m: float = 3.0
    """A longer side is a vehicle's length [m]."""
    car_width_max_m: float = 2.1
    """A longer truncated side is a vehicle's length, too [m]: more than a car's width."""
    depth_min_m: float = 1.5
    """If the shorter side is longer than this, about the width of a car, the longer side is the length [m]."""
    course_speed_min_mps: float = 1.0
    """Minimum speed at which the direction of motion defines the front [m/s]."""
    course_sigma: float = 4.0
    """Minimum speed for the same, in standard deviations."""
    reversal_m: float = 0.5
    """Distance that a vehicle moves backwards before its heading is reversed [m]."""
    sideways_m: float = 2.6
    """Distance that a vehicle moves sideways before its heading is turned [m]: the edge of a stationary vehicle that
    comes into view behind another one seems to move, by the vehicle's width at most."""
    votes: int = 5
    """Successive frames in which the size contradicts the heading of a stationary vehicle before it is turned."""


def turn_sign(sign: Ints, quarters: int) -> Ints:
    """(2,) signs of the same corner in a frame turned counter-clockwise by `quarters`."""
    x, y = sign
    return np.array([(x, y), (y, -x), (-x, -y), (-y, x)][quarters % 4], dtype=np.int64)


def turn_size(size: Floats, quarters: int) -> Floats:
    """(2,) the same sides in a frame turned by `quarters`."""
    return size[::-1].copy() if quarters % 2 else size


def first_guess(heading: float, size: Floats, whole: Bools, forward: float, config: OrientationConfig) -> int:
    """Quarter turns from the heading of a new box to that of the vehicle.

    The length lies along the longer side, unless only one short side is visible, which is then the width. Of the two
    remaining directions, the one nearer to the ego's heading is used until the vehicle moves.

    Parameters
    ----------
    heading
        Heading of the box [rad].
    size
        (2,) sides of the box along and across [m].
    whole
        (2,) mask of sides that are not truncated.
    forward
        Heading of the ego [rad].
    """
    longer = int(np.argmax(size))
    width_max = config.width_max_m if whole[longer] else config.car_width_max_m
    only_width = size.max() < width_max and size.min() < config.depth_min_m
    axis = heading + QUARTER * (longer != only_width)
    against = np.cos(axis - forward) < 0
    return int(longer != only_width) + 2 * int(against)


class Course(NamedTuple):
    """Direction of motion."""

    direction: float
    """[rad]."""
    variance: float
    """[rad^2]."""


def course(velocity: Floats, covariance: Floats, config: OrientationConfig) -> Course | None:
    """Direction of a velocity (2,) [m/s] with covariance (2, 2), None if it is not significant."""
    significance = velocity @ np.linalg.solve(covariance, velocity)
    if np.hypot(*velocity) < config.course_speed_min_mps or significance < config.course_sigma**2:
        return None
    x, y = velocity.tolist()
    across = np.array([-y, x]) / (x * x + y * y)
    return Course(math.atan2(y, x), float(across @ covariance @ across))


def by_course(heading: float, course: float) -> int:
    """Quarter turns by which the direction of motion contradicts the heading."""
    return int(np.round(wrap(course - heading) / QUARTER)) % 4


def by_size(heading: float, size: Floats, whole: Bools, forward: float, config: OrientationConfig) -> int:
    """Quarter turns by which the seen size contradicts the heading: 1 or 3 if length and width are swapped, else 0."""
    quarters = first_guess(heading, size, whole, forward, config)
    return quarters if quarters % 2 else 0


def way_needed(quarters: int, size: Floats, config: OrientationConfig) -> float:
    """Distance that a vehicle of seen size (2,) [m] must move against its heading before the heading is turned [m].

    While a stationary side comes into view, its end seems to move by the length of the side at most.
    """
    if quarters % 2 == 0:
        return config.reversal_m
    return max(config.sideways_m, float(size[0]))

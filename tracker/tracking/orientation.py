"""Front of a vehicle: resolves the quarter-turn ambiguity of a rectangle's heading, without flips."""

from typing import NamedTuple

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
from luxloop.tracker.geometry import QUARTER, wrap
from luxloop.tracker.tracking.traffic_flow import TrafficFlow
from luxloop.tracker.vehicle_classes import FACE_MIN_M, TRUNCATED_PROBABILITY, length_log_odds

COURSE_SPEED_MIN_MPS = 1.0
"""Minimum speed at which the direction of motion defines the front [m/s]."""

COURSE_SIGMA = 4.0
"""Minimum speed for the same, in standard deviations."""

REVERSAL_M = 0.5
"""Distance that a vehicle moves backwards before its heading is reversed [m]."""

SIDEWAYS_M = 2.6
"""Distance that a vehicle moves sideways before its heading is turned [m]: the edge of a stationary vehicle that
comes into view behind another one seems to move, by the vehicle's width at most."""

TURN_LOG_ODDS = 1.0
"""Minimum log-odds against the heading of a stationary vehicle for a turn: a hysteresis."""


def turn_sign(sign: Ints, quarters: int) -> Ints:
    """(2,) signs of the same corner in a frame turned counter-clockwise by `quarters`."""
    x, y = sign
    return np.array([(x, y), (y, -x), (-x, -y), (-y, x)][quarters % 4], dtype=np.int64)


def turn_size(size: Floats, quarters: int) -> Floats:
    """(2,) the same sides in a frame turned by `quarters`."""
    return size[::-1].copy() if quarters % 2 else size


def shape_log_odds(size: Floats, whole: Bools) -> float:
    """Return the log-odds of a view of two sides (2,) [m] that the first one is the length; `whole` (2,) is a mask."""
    return length_log_odds(size, whole, FACE_MIN_M, TRUNCATED_PROBABILITY)


def likeliest_turns(length_log_odds: float, place: Floats, heading: float, flow: TrafficFlow, least: float) -> int:
    """Return the quarter turns from a heading to the likeliest direction of a vehicle that has not moved.

    Parameters
    ----------
    length_log_odds
        Log-odds by shape that the length of the vehicle is along the heading.
    place
        (2,) position of the vehicle [m].
    heading
        [rad].
    least
        Minimum log-odds against the heading for a turn.
    """
    across = length_log_odds + flow.axis_log_odds(place, heading) < -least
    back = flow.front_log_odds(place, heading + QUARTER * across) < (0.0 if across else -least)
    return int(across) + 2 * int(back)


def correlated_sum(total: float, views: int, correlation: float) -> float:
    """Return the evidence of a `total` of log-odds over views of one object, whose errors are correlated.

    The evidence of n equal views with correlation r is that of n / (1 + (n - 1) r).
    """
    return total / (1.0 + correlation * max(views - 1, 0))


class Course(NamedTuple):
    """Direction of motion."""

    direction: float
    """[rad]."""
    variance: float
    """[rad^2]."""


def course(velocity: complex, covariance: tuple[float, float, float]) -> Course | None:
    """Direction of a velocity [m/s] with covariance xx, xy, yy, None if it is not significant."""
    x, y, (xx, xy, yy) = velocity.real, velocity.imag, covariance
    squared = x * x + y * y
    if abs(velocity) < COURSE_SPEED_MIN_MPS:
        return None
    if yy * x * x - 2.0 * xy * x * y + xx * y * y < COURSE_SIGMA**2 * (xx * yy - xy * xy):
        return None
    return Course(elementary.atan2(y, x), (xx * y * y - 2.0 * xy * x * y + yy * x * x) / squared**2)


def by_course(heading: float, course: float) -> int:
    """Quarter turns by which the direction of motion contradicts the heading."""
    return round(wrap(course - heading) / QUARTER) % 4


def way_needed(quarters: int, size: Floats) -> float:
    """Distance that a vehicle of seen size (2,) [m] must move against its heading before the heading is turned [m].

    While a stationary side comes into view, its end seems to move by the length of the side at most.
    """
    if quarters % 2 == 0:
        return REVERSAL_M
    return max(SIDEWAYS_M, float(size[0]))

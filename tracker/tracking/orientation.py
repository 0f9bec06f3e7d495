"""Front of a vehicle: resolves the quarter-turn ambiguity of a rectangle's heading, without flips."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.bounds import require_within
from luxloop.tracker.geometry import QUARTER, wrap
from luxloop.tracker.tracking.traffic_flow import FlowConfig, TrafficFlow
from luxloop.tracker.tracking.vehicle_classes import length_log_odds


@dataclass(frozen=True, slots=True)
class OrientationConfig:
    """Choice among the four directions of a rectangle."""

    width_max_m: float = 3.0
    """A longer side is a vehicle's length [m]."""
    course_speed_min_mps: float = 1.0
    """Minimum speed at which the direction of motion defines the front [m/s]."""
    course_sigma: float = 4.0
    """Minimum speed for the same, in standard deviations."""
    reversal_m: float = 0.5
    """Distance that a vehicle moves backwards before its heading is reversed [m]."""
    sideways_m: float = 2.6
    """Distance that a vehicle moves sideways before its heading is turned [m]: the edge of a stationary vehicle that
    comes into view behind another one seems to move, by the vehicle's width at most."""
    visible_min_m: float = 0.6
    """A side with a smaller visible extent may face away [m]; corners are rounded by 0.25 to 0.4."""
    truncated_probability: float = 0.3
    """Probability that a side that seems whole is truncated: thin occluders and lost beams are not detected."""
    view_correlation: float = 0.3
    """Correlation of successive views of a stationary vehicle: many equal views have the evidence of three."""
    turn_log_odds: float = 1.0
    """Minimum log-odds against the heading of a stationary vehicle for a turn: a hysteresis."""
    flow: FlowConfig = field(default_factory=FlowConfig)
    """Directions of neighbours and of the ego."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1.0, "truncated_probability", "view_correlation")


def turn_sign(sign: Ints, quarters: int) -> Ints:
    """(2,) signs of the same corner in a frame turned counter-clockwise by `quarters`."""
    x, y = sign
    return np.array([(x, y), (y, -x), (-x, -y), (-y, x)][quarters % 4], dtype=np.int64)


def turn_size(size: Floats, quarters: int) -> Floats:
    """(2,) the same sides in a frame turned by `quarters`."""
    return size[::-1].copy() if quarters % 2 else size


def turn_sides(size: Floats, whole: Bools, quarters: int) -> tuple[Floats, Bools]:
    """Return the same sides and masks (2,) in a frame turned by `quarters`."""
    return (size[::-1].copy(), whole[::-1].copy()) if quarters % 2 else (size, whole)


def shape_log_odds(size: Floats, whole: Bools, config: OrientationConfig) -> float:
    """Return the log-odds of a view of two sides (2,) [m] that the first one is the length; `whole` (2,) is a mask."""
    return length_log_odds(size, whole, config.visible_min_m, config.truncated_probability)


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


class Course(NamedTuple):
    """Direction of motion."""

    direction: float
    """[rad]."""
    variance: float
    """[rad^2]."""


def course(velocity: complex, covariance: tuple[float, float, float], config: OrientationConfig) -> Course | None:
    """Direction of a velocity [m/s] with covariance xx, xy, yy, None if it is not significant."""
    x, y, (xx, xy, yy) = velocity.real, velocity.imag, covariance
    squared = x * x + y * y
    if abs(velocity) < config.course_speed_min_mps:
        return None
    if yy * x * x - 2.0 * xy * x * y + xx * y * y < config.course_sigma**2 * (xx * yy - xy * xy):
        return None
    return Course(math.atan2(y, x), (xx * y * y - 2.0 * xy * x * y + yy * x * x) / squared**2)


def by_course(heading: float, course: float) -> int:
    """Quarter turns by which the direction of motion contradicts the heading."""
    return round(wrap(course - heading) / QUARTER) % 4


def way_needed(quarters: int, size: Floats, config: OrientationConfig) -> float:
    """Distance that a vehicle of seen size (2,) [m] must move against its heading before the heading is turned [m].

    While a stationary side comes into view, its end seems to move by the length of the side at most.
    """
    if quarters % 2 == 0:
        return config.reversal_m
    return max(config.sideways_m, float(size[0]))

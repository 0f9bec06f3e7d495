"""Existence of hidden vehicles: probability that an unseen track is still where it is predicted.

A vehicle that is not seen is behind something, or it is no longer on its course. The existence probability of
integrated data association (Musicki and Evans 1994) is applied to the whole time without an observation, because
successive scans see the same free places.
"""

import math
from dataclasses import dataclass

from luxloop.tracker.bounds import require_within

CLUTTER_PER_M2 = 0.0005
"""Density of boxes of other objects where a hidden vehicle may reappear [1/m^2]: of the boxes without a confirmed
track within 40 m in six scenes, 0.00002 to 0.0005."""

FREE_MARGIN_M = 1.0
"""Minimum distance between a free place and the returns behind it [m]."""


@dataclass(frozen=True, slots=True)
class ExistenceConfig:
    """Memory of vehicles that are hidden."""

    course_s: float = 4.0
    """Mean time in which a hidden vehicle keeps its predicted course [s]."""
    existence_min: float = 0.1
    """A coasting track with a smaller probability of existence is terminated."""
    std_max_m: float = 6.0
    """A coasting track with a larger standard deviation of its position is terminated [m]: the spacing of vehicles in a
    queue, beyond which the next one is as near to the prediction."""
    unit_offset_m: float = 2.5
    """Maximum distance of a unit from the ego's centre [m]."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1.0, "existence_min")
        require_within(self, 1e-3, 1e6, "course_s", "std_max_m")
        require_within(self, 0.0, 1e3, "unit_offset_m")


def existence(unseen_s: float, hidden: float, config: ExistenceConfig) -> float:
    """Return the probability that a vehicle, unseen for a time [s], exists on its course.

    A share `hidden` of the places where it is predicted is not known to be free. With the probability s of keeping the
    course, the existence is s h / (s h + 1 - s).
    """
    if hidden == 0.0:
        return 0.0
    keeps = math.exp(-unseen_s / config.course_s)
    return keeps * hidden / (keeps * hidden + (1.0 - keeps))


def same_vehicle(unseen_s: float, density_per_m2: float, config: ExistenceConfig) -> float:
    """Return the probability that a box is the vehicle that was unseen for a time [s], and no other object.

    The box has the predicted density [1/m^2] at its place.
    """
    vehicle = math.exp(-unseen_s / config.course_s) * density_per_m2
    return vehicle / (vehicle + CLUTTER_PER_M2)

"""Second observation of a new track: any speed along an axis of the vehicle, if shape and heading agree.

A track starts without a velocity. The gate of its prior speed admits urban traffic. A faster vehicle is found by the
motion between two scans (two-point initiation, Bar-Shalom, Li, Kirubarajan 2001, section 5.5.3): rigid, along its
length, and within the speed of any vehicle.
"""

from dataclasses import dataclass

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.bounds import require_within
from luxloop.tracker.geometry import rotate
from luxloop.tracker.tracking.hypotheses import Hypotheses, Predictions
from luxloop.tracker.tracking.observations import Observations


@dataclass(frozen=True, slots=True)
class BirthConfig:
    """Conditions for two boxes of successive scans to be one vehicle."""

    speed_max_mps: float = 75.0
    """Maximum speed of a vehicle over ground [m/s]: 270 km/h."""
    sideways_share: float = 0.1
    """Maximum motion across the heading as a share of the motion along it: 6 degrees, three of a fit's errors."""
    sideways_m: float = 0.5
    """Maximum motion across the heading that errors of two fits explain [m]."""
    turn_sigma: float = 3.0
    """Maximum difference of the headings, in standard deviations."""
    heading_std_rad: float = 0.05
    """Heading error of a fit beyond its covariance [rad]: rounded corners that are fitted as sides."""
    size_max_m: float = 1.5
    """Maximum difference of a side that both views show [m]: more of it comes into view between two scans."""
    nearby_m: float = 1.0
    """Within this distance the gate decides, because errors of partial views exceed the motion [m]."""
    side_min_m: float = 1.0
    """Minimum visible extent of a side [m]; a shorter one may face away. Both views must show one side."""

    def __post_init__(self) -> None:
        require_within(self, 1e-6, 1e3, "speed_max_mps", "size_max_m", "side_min_m", "turn_sigma", "heading_std_rad")
        require_within(self, 0.0, 1e3, "sideways_share", "sideways_m", "nearby_m")


def nearby(hypotheses: Hypotheses, config: BirthConfig) -> Bools:
    """(T, B) mask of boxes that are at the place of the track."""
    return np.asarray(np.hypot(hypotheses.misfit[:, :, 0, 0], hypotheses.misfit[:, :, 0, 1]) < config.nearby_m)


def second_views(
    tracks: Predictions,
    hypotheses: Hypotheses,
    seen: Observations,
    age_s: Floats,
    seen_size: Floats,
    config: BirthConfig,
) -> Bools:
    """(T, B) mask of boxes that may be the second view of a vehicle.

    Parameters
    ----------
    age_s
        (T,) time since the first view [s].
    seen_size
        (T, 2) extent of the first view along and across the heading [m].
    """
    moved = np.abs(rotate(hypotheses.misfit[:, :, 0], -tracks.heading[:, None]))
    # The box of a new track has a quarter-turn ambiguity: either axis may be the length.
    along, across = np.maximum(moved[:, :, 0], moved[:, :, 1]), np.minimum(moved[:, :, 0], moved[:, :, 1])
    straight = across < config.sideways_m + config.sideways_share * along
    variance = tracks.heading_variance[:, None] + seen.covariance[:, 2, 2] + config.heading_std_rad**2
    turn = np.abs(hypotheses.heading - tracks.heading[:, None]) / np.sqrt(variance)
    both = np.minimum(hypotheses.size, seen_size[:, None]) > config.side_min_m
    differs = both & (np.abs(hypotheses.size - seen_size[:, None]) > config.size_max_m)
    same = both.any(axis=2) & ~differs.any(axis=2) & (turn < config.turn_sigma)
    return np.asarray(same & straight & (along < age_s[:, None] * config.speed_max_mps))

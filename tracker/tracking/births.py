"""Second observation of a new track: any speed along an axis of the vehicle, if shape and heading agree.

A track starts without a velocity. The gate of its prior speed admits urban traffic. A faster vehicle is found by the
motion between two scans (two-point initiation, Bar-Shalom, Li, Kirubarajan 2001, section 5.5.3): rigid, along its
length, and within the speed of any vehicle.
"""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats
from tracker.bounds import require_within
from tracker.geometry import rotate
from tracker.tracking.hypotheses import Hypotheses, Predictions


@dataclass(frozen=True, slots=True)
class BirthConfig:
    """Conditions for two boxes of successive scans to be one vehicle."""

    speed_max_mps: float = 75.0
    """Maximum speed of a vehicle over ground [m/s]: 270 km/h."""
    sideways_share: float = 0.1
    """Maximum motion across the heading as a share of the motion along it: 6 degrees, three of a fit's errors."""
    sideways_m: float = 0.5
    """Maximum motion across the heading that errors of two fits explain [m]."""
    turn_max_rad: float = 0.2
    """Maximum difference of the headings [rad]: four standard deviations of two fits, and a tight turn at 12.5 Hz."""
    size_max_m: float = 1.5
    """Maximum difference of a side that both views show [m]: more of it comes into view between two scans."""
    side_min_m: float = 1.0
    """Minimum visible extent of a side [m]; a shorter one may face away. Both views must show one side."""

    def __post_init__(self) -> None:
        require_within(self, 1e-6, 1e3, "speed_max_mps", "size_max_m", "side_min_m")
        require_within(self, 0.0, 1e3, "sideways_share", "sideways_m", "turn_max_rad")


def births(
    tracks: Predictions,
    hypotheses: Hypotheses,
    age_s: Floats,
    seen_size: Floats,
    config: BirthConfig,
) -> tuple[Floats, Bools]:
    """Return the cost (T, B) of each pair, and a mask (T, B) of boxes that may be the second view of a new vehicle.

    Parameters
    ----------
    age_s
        (T,) time since the first view [s], infinite for tracks that are not new.
    seen_size
        (T, 2) extent of the first view along and across the heading [m].
    """
    moved = rotate(hypotheses.misfit[:, :, 0], -tracks.heading[:, None])
    # The box of a new track has a quarter-turn ambiguity: either axis may be the length.
    along, across = np.abs(moved).max(axis=2), np.abs(moved).min(axis=2)
    turn = np.abs(hypotheses.heading - tracks.heading[:, None])
    both = np.minimum(hypotheses.size, seen_size[:, None]) > config.side_min_m
    size = np.where(both, np.abs(hypotheses.size - seen_size[:, None]), 0.0).max(axis=2)
    limit = np.where(np.isfinite(age_s), age_s, 0.0)[:, None] * config.speed_max_mps
    sideways = across / (config.sideways_m + config.sideways_share * along)
    agrees = (turn < config.turn_max_rad) & (size < config.size_max_m) & (sideways < 1.0)
    cost = (turn / config.turn_max_rad) ** 2 + (size / config.size_max_m) ** 2 + sideways**2
    return np.asarray(cost), np.asarray(agrees & both.any(axis=2) & (along < limit))

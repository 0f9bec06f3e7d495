"""Possible range of each metric, which its intervals do not leave."""

import math
import re

Range = tuple[float, float]

UNBOUNDED_RATIOS = ("bound_ratio", "nees_mean", "nis_mean", "_per_frame", "_per_vehicle", "_per_observation", "factor")
"""Ends of the names of metrics of unit 1 that can exceed 1."""
SIGNED = re.compile(r"(?<!abs)_mean_(deg|m|mps)$|^mma\.gain\.|_(ttc|meeting)_(s|m)$|min_(ttc_s|gap_m)$")
"""Names of metrics that can be negative: mean errors with their sign, and distances that fall below zero."""
UNSIGNED_MEANS = ("track.standing_speed_mean_mps", "track.heading_unflipped_mean_deg")
"""Means that match `SIGNED`, of quantities that are never negative."""
FIT_HEADING_DEG, TRACK_HEADING_DEG = 45.0, 180.0
"""Largest errors of headings modulo 90 and modulo 360 degrees."""


def possible_range(name: str, unit: str) -> Range:
    """Return the least and the largest possible value of a metric, infinite where it has no limit."""
    base = re.sub(r"\.by_\w+\..*$|_around_changes$", "", name)
    if base.endswith(".mota"):
        return -math.inf, 1.0
    largest = _largest_deg(base) if unit == "deg" else math.inf
    if SIGNED.search(base) and base not in UNSIGNED_MEANS:
        return -largest, largest
    if unit == "1" and not base.endswith(UNBOUNDED_RATIOS):
        return 0.0, 1.0
    return 0.0, largest


def _largest_deg(base: str) -> float:
    """Return the largest size of an error of the heading; deviations of sizes are at most half of it."""
    if not base.startswith("fit."):
        return TRACK_HEADING_DEG
    return 0.5 * FIT_HEADING_DEG if base.endswith("abs_std_deg") else FIT_HEADING_DEG

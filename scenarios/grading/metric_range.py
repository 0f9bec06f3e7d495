"""Possible range of each metric, which its intervals do not leave."""

import math
import re

from luxloop.scenarios.grading.metric_names import REGISTRY

Range = tuple[float, float]

UNBOUNDED_RATIOS = ("bound_ratio", "nees_mean", "nis_mean", "_per_frame", "_per_vehicle", "_per_observation", "factor")
"""Ends of the names of metrics of unit 1 that can exceed 1."""
SIGNED = re.compile(r"(?<!abs)_mean_(deg|m|mps)$|^mma\.gain\.|_(ttc|meeting)_(s|m)$|min_(ttc_s|gap_m)$")
"""Names of metrics that can be negative: mean errors with their sign, and distances that fall below zero."""
UNSIGNED_MEANS = ("track.standing_speed_mean_mps",)
"""Means that match `SIGNED`, of quantities that are never negative."""


def possible_range(name: str) -> Range:
    """Return the least and the largest possible value of a metric, infinite where it has no limit."""
    base = re.sub(r"\.by_\w+\..*$|_around_changes$", "", name)
    if base.endswith(".mota"):
        return -math.inf, 1.0
    if SIGNED.search(base) and base not in UNSIGNED_MEANS:
        return -math.inf, math.inf
    if REGISTRY[name].unit == "1" and not base.endswith(UNBOUNDED_RATIOS):
        return 0.0, 1.0
    return 0.0, math.inf

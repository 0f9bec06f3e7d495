"""Confidence level and least number of clusters of all printed intervals."""

CONFIDENCE = 0.95
TAIL = 0.5 * (1.0 - CONFIDENCE)
FEWEST_SEEDS = 5
"""Fewest seeds with an interval of a median. The extremes of four values contain their median in 88 % of the cases only
(1 - 2 / 2**4); those of five in 94 %."""
FEWEST_CLUSTERS = 3
"""Fewest vehicles with an interval. Two nearly always differ in their number of observations, so that one dominates."""

Interval = tuple[float, float]

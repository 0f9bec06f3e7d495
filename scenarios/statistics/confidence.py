"""Confidence level of all printed intervals, and when a figure has none."""

CONFIDENCE = 0.95
TAIL = 0.5 * (1.0 - CONFIDENCE)
FEWEST_SEEDS = 5
"""Fewest seeds with an interval of a median. The extremes of four values contain their median in 88 % of the cases only
(1 - 2 / 2**4); those of five in 94 %."""
FEWEST_CLUSTERS = 3
"""Fewest effective vehicles with an interval: equal ones that have the same variance. Student's quantile is 4.3 for
three, but 12.7 for two, so that limits of two mean nothing."""

TOO_FEW = "too few vehicles"
"""Printed where a figure over vehicles has no interval."""
NO_ERROR = "no vehicle has an error"
"""Printed where an interval would have no scale, because all vehicles are at the best value."""

Interval = tuple[float, float]

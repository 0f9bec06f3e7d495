"""Known failures: the figure at the beginning of their text, and the range of values that it excuses.

The range lies around the figure of the run, as in any measurement with a tolerance. It is wide enough for small changes
of the tracker, and so narrow that a clear loss leaves it:

- counts: the larger of 2 and 30 %, because rare events are nearly Poisson distributed, with a standard deviation of the
  square root of the count;
- shares and scores: 10 % of the value or of its complement, whichever is smaller, but at least 0.01;
- other units: 10 %.
"""

import math
import re

COUNT, SHARE = "count", "1"
"""Units with rules of their own."""

_FIGURE = re.compile(r"\s*([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)\s*:\s*(?=\S)")


def figure_of(text: str) -> float | None:
    """Return the figure of a text `FIGURE: CAUSE`, None if it has none."""
    found = _FIGURE.match(text)
    return float(found[1]) if found else None


def cause_of(text: str) -> str:
    """Return a text `FIGURE: CAUSE` without its figure."""
    return _FIGURE.sub("", text, count=1)


def tolerance(figure: float, unit: str) -> float:
    """Return how far a value may be from the figure, in the metric's unit."""
    if unit == COUNT:
        return max(2.0, 0.3 * abs(figure))
    if unit == SHARE:
        return max(0.01, 0.1 * min(abs(figure), abs(1.0 - figure)))
    return 0.1 * abs(figure)


def worst_values(figure: float | None, smallest: float | None, largest: float | None, unit: str) -> tuple[float, float]:
    """Return the smallest and the largest excused value.

    Parameters
    ----------
    figure
        Of the known failure; None excuses any value.
    smallest, largest
        Limits of the expectation; the range begins at the limit if the figure holds. None: no such limit.
    unit
        Unit of the metric.
    """
    if figure is None:
        return -math.inf, math.inf
    spread = tolerance(figure, unit)
    low = -math.inf if smallest is None else min(figure, smallest) - spread
    high = math.inf if largest is None else max(figure, largest) + spread
    return low, high

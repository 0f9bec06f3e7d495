"""Warnings of figures from few seeds, or from one seed that dominates."""

import numpy as np

from luxloop.scenarios.arrays import Floats

FEW_SEEDS = 10
"""Fewest seeds without a warning."""
DOMINANT = 0.5
"""Share of the sum over seeds that one seed has if it dominates."""
FEWEST_COMPARED = 3
"""Fewest seeds of which one can dominate."""


def few_seeds(seeds: int) -> str:
    """Return a warning for fewer than `FEW_SEEDS`, else an empty text."""
    return f"only {seeds} seeds: intervals are wide, and rare outcomes are not in them" if seeds < FEW_SEEDS else ""


def is_dominated(values: Floats) -> bool:
    """Return True if one of the `values` (n,), one per seed, has more than half of the sum of their magnitudes."""
    size = np.abs(values)
    return len(size) >= FEWEST_COMPARED and bool(size.max() > DOMINANT * size.sum() > 0.0)

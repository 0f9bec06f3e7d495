"""Coverage of the heading's intervals by view and band, over many runs."""

from collections.abc import Iterator
from statistics import NormalDist

import numpy as np
import pandas as pd
from fits.league import FEWEST
from fits.league_tables import markdown
from fits.observations import groups

from luxloop.scenarios.metrics.definitions import COVERAGES
from luxloop.scenarios.statistics.jackknife import SHARE, ratio_interval


def table(observed: pd.DataFrame) -> str:
    """Return a row per group: shares of true headings inside the intervals of the boxes, with 95 % intervals."""
    boxed = observed[observed["deviation"].notna()]
    if boxed.empty:
        return "No run has heading variances of boxes; run the scenarios again."
    head = ("observations", "n", *(f"in {percent} % [95 %]" for percent in COVERAGES))
    return markdown(head, _rows(boxed))


def _rows(boxed: pd.DataFrame) -> Iterator[tuple[object, ...]]:
    for name, group in groups(boxed):
        if len(group) >= FEWEST:
            yield (name, len(group), *(_share(group, percent) for percent in COVERAGES))


def _share(group: pd.DataFrame, percent: int) -> str:
    inside = (group["deviation"].to_numpy() <= NormalDist().inv_cdf(0.5 + 0.005 * percent)).astype(np.float64)
    interval = ratio_interval(group["vehicle"].to_numpy(), inside, np.ones(len(inside)), SHARE)
    ends = f" [{100 * interval[0]:.1f}, {100 * interval[1]:.1f}]" if interval else ""
    return f"{100 * inside.mean():.1f} %{ends}"

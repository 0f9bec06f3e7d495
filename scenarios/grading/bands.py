"""Rows of vehicles by range, class and view: `BANDS` of the names of metrics."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools
from luxloop.scenarios.grading.track_metric_names import CLASSES, RANGE_BANDS, SEEN

WHOLE = ""
"""End of the name of a metric of all rows."""


def bands(rows: pd.DataFrame) -> Iterator[tuple[str, Bools]]:
    """Yield the end of the metric's name and the mask (n,) of its rows: all of them, then each band.

    Parameters
    ----------
    rows
        A row per observation, with `range_m` [m], `kind` and `view` of the vehicle.
    """
    yield WHOLE, np.ones(len(rows), np.bool_)
    yield from range_bands(rows)
    kind = rows["kind"].to_numpy(np.str_)
    for name in CLASSES:
        yield f".by_class.{name}", np.asarray(kind == name)
    view = rows["view"].to_numpy(np.str_)
    for name in SEEN:
        yield f".by_view.{name}", np.asarray(view == name)


def range_bands(rows: pd.DataFrame) -> Iterator[tuple[str, Bools]]:
    """Yield the end of the metric's name and the mask (n,) of the rows of each band of `range_m` [m]."""
    distance = rows["range_m"].to_numpy(np.float64)
    for name, (low, high) in RANGE_BANDS.items():
        yield f".by_range.{name}", np.asarray((distance >= low) & (distance < high))


def why_none(band: str, why: str, rows: int) -> str:
    """Return the reason of a missing value: `why` if there are no `rows` at all."""
    return f"no observation is in the band {band[1:]}" if band and rows else why

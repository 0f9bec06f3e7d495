"""Matching of simulated to real vehicles by the view of the LIDAR."""

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from luxloop.scenarios.arrays import Floats, Ints

RANGE_SCALE = 0.15
"""Difference of log ranges that counts as 1."""
ASPECT_SCALE_DEG = 8.0
"""Difference of aspects that counts as 1 [deg]."""
NEAREST = 3
"""Simulated vehicles per real one."""


def match(real: pd.DataFrame, simulated: pd.DataFrame) -> tuple[Ints, Ints, Floats]:
    """Return the nearest simulated vehicles with the same end seen for every real one.

    Parameters
    ----------
    real, simulated
        Tables with the columns range_m, aspect_deg and front_seen.

    Returns
    -------
    real_row
        (M,) rows of the real table; those without a simulated vehicle that shows the same end are missing.
    simulated_row
        (M,) rows of the simulated one, up to `NEAREST` for each real row.
    distance
        (M,) distance of the views, in scales.
    """
    rows: list[tuple[int, int, float]] = []
    for front in (False, True):
        ours, theirs = (np.flatnonzero(table["front_seen"].to_numpy() == front) for table in (simulated, real))
        count = min(NEAREST, len(ours))
        if not count or not len(theirs):
            continue
        distance, index = cKDTree(_view(simulated.iloc[ours])).query(_view(real.iloc[theirs]), k=range(1, count + 1))
        rows += zip(np.repeat(theirs, count), ours[index.ravel()], distance.ravel(), strict=True)
    rows.sort(key=lambda row: row[0])
    real_row, simulated_row, gap = (np.array(column) for column in zip(*rows, strict=True)) if rows else ([], [], [])
    return np.asarray(real_row, np.int64), np.asarray(simulated_row, np.int64), np.asarray(gap, np.float64)


def _view(table: pd.DataFrame) -> Floats:
    """(N, 2) log range and aspect, in scales."""
    view: Floats = np.column_stack([np.log(table["range_m"]) / RANGE_SCALE, table["aspect_deg"] / ASPECT_SCALE_DEG])
    return view

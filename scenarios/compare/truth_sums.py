"""Means of the truth per vehicle, to recognise the same vehicle in two runs within tolerances.

The last bits of simulated values depend on the instruction set of the CPU. A hash of the truth would differ, and so
would a hash of rounded values whenever one of them lies at a border of rounding. Means are compared within tolerances.
"""

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.compare.vehicle_rows import VehicleRows

TRACKER_COLUMNS = ("track_id", "segments", "largest_segment_share")
"""Columns of the truth table that depend on the tracker."""

TRUTH = ("frames", "x_world_m", "y_world_m", "range_m", "points", "others")
"""Per vehicle: number of frames, means over them, and the mean of the weighted sum of all other columns."""

DECIMALS = 7
"""Decimals of a mean."""
ABSOLUTE = 1e-6
"""Tolerance of a mean, in the column's unit. Another CPU changes means by 1e-11 at most in the shipped catalog."""
RELATIVE = 1e-9
"""Tolerance of a large mean, as a share of it."""


def truth_sums(rows: VehicleRows, truth: pd.DataFrame) -> Floats:
    """Return the means (V, len(TRUTH)) of the truth table; actors that were never graded share the first row."""
    actor = truth["actor_id"]
    frames = rows.sum(actor)
    named = [np.nan_to_num(truth[name].to_numpy(np.float64)) for name in TRUTH[1:-1]]  # files may lack ranges
    used = {"frame", "actor_id", "name", *TRUTH, *TRACKER_COLUMNS}
    others = [_numbers(truth[name]) for name in truth.columns if name not in used]
    # Different weights, so that an exchange of two columns shows.
    weighted = sum((weight * column for weight, column in enumerate(others, start=1)), start=np.zeros(len(truth)))
    means = [rows.sum(actor, column) / np.maximum(frames, 1.0) for column in (*named, weighted)]
    rounded: Floats = np.column_stack([frames, *means]).round(DECIMALS)
    return rounded


def _numbers(column: "pd.Series[float]") -> Floats:
    """Return a column as continuous numbers: codes of categories, 0 for missing values, and no jumps at +-pi."""
    if isinstance(column.dtype, pd.CategoricalDtype):
        codes: Floats = column.cat.codes.to_numpy(np.float64)
        return codes
    values = np.nan_to_num(column.to_numpy(np.float64))
    numbers: Floats = np.cos(values) + 2.0 * np.sin(values) if str(column.name).endswith("_rad") else values
    return numbers


def counterparts(base: Ints, head: Ints, base_truth: Floats, head_truth: Floats) -> tuple[Ints, Ints]:
    """Return the rows of BASE and of HEAD of the vehicles with equal truth, in ascending order of their ids.

    Parameters
    ----------
    base, head
        (V,) and (W,) ids of the vehicles.
    base_truth, head_truth
        (V, len(TRUTH)) and (W, len(TRUTH)) as from `truth_sums`.
    """
    _, b, h = np.intersect1d(base, head, assume_unique=True, return_indices=True)
    same = close(base_truth[b], head_truth[h])
    return b[same].astype(np.int64), h[same].astype(np.int64)


def close(base: npt.NDArray[np.float64], head: npt.NDArray[np.float64]) -> Bools:
    """(V,) True for the rows (V, len(TRUTH)) that are equal within the tolerances."""
    return np.asarray(np.isclose(base, head, rtol=RELATIVE, atol=ABSOLUTE).all(axis=1))

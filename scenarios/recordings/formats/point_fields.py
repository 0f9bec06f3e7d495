"""Fields of points by name, as in PointCloud2 and PCD: coordinates, rings and times."""

from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.sweep import Sweep

RING_NAMES = ("ring", "line", "layer", "channel")
TIME_NAMES = ("t", "time", "time_stamp", "timestamp", "offset_time")
"""Names of fields of rings and of times: Velodyne, Ouster, Hesai, Livox and Robosense drivers differ."""
NANOSECONDS = 1e-9
CLOCK_S = 1e6
"""[s] Larger times of points are on the clock of the recording, and not relative to the sweep."""


def sweep_of_table(table: npt.NDArray[np.void], time: float, unit: int) -> Sweep:
    """Return the points of a structured array (N,). Missing returns, NaN or at the origin, are left out.

    Parameters
    ----------
    table
        Fields `x`, `y`, `z` [m], and as far as present one of `RING_NAMES` and one of `TIME_NAMES`.
    time
        Time of the sweep [s].
    unit
        Number of the LIDAR.

    Raises
    ------
    InputError
        A coordinate is missing.
    """
    names = table.dtype.names or ()
    if missing := [name for name in "xyz" if name not in names]:
        raise InputError(f"points have no field {missing[0]}; they have {', '.join(names) or 'none'}")
    points = np.column_stack([table[name].astype(np.float64) for name in "xyz"])
    kept = np.isfinite(points).all(axis=1) & (points != 0.0).any(axis=1)
    ring = next((table[name].astype(np.int64) for name in RING_NAMES if name in names), None)
    offset = next((_time_offset(table[name], time) for name in TIME_NAMES if name in names), np.zeros(len(points)))
    return Sweep(time, unit, points, offset, ring).subset(kept)


def _time_offset(values: npt.NDArray[Any], time: float) -> Floats:
    """Return times (N,) after that of the sweep [s]: integers are nanoseconds, floats seconds."""
    offset = values.astype(np.float64) * (NANOSECONDS if values.dtype.kind in "iu" else 1.0)
    return np.where(np.abs(offset) > CLOCK_S, offset - time, offset)

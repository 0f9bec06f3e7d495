"""Files of one sweep each as a recording, and sweeps of tables of points, whatever their fields are called."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.sweep import PoseList, Sweep

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


@dataclass(frozen=True, slots=True)
class PointFiles:
    """Files in the order of time, as a `RecordingSource`."""

    paths: list[Path]
    read: Callable[[Path], npt.NDArray[np.void]]
    """Reader of the points (N,) of a file, with its fields."""
    what: str
    """Name of the format in messages."""
    period_s: float
    """Time between two files [s]."""

    @property
    def count(self) -> int | None:
        """Number of files."""
        return len(self.paths)

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the points of each file."""
        for number, path in enumerate(self.paths):
            with readable(path, self.what):
                sweep = sweep_of_table(self.read(path), number * self.period_s, 0)
            yield sweep

    def poses(self, name: str) -> PoseList:
        """Raise an InputError: these files hold no poses."""
        raise InputError(f"{self.paths[0]}: {name}: files of points hold no poses; leave --odometry and --truth out")

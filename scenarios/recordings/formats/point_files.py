"""Files of one sweep each as a recording, and sweeps of tables of points with the field names of common drivers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Floats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.sweep import PoseList, Sweep

RING_NAMES = ("ring", "line", "layer", "channel")
TIME_NAMES = ("t", "time", "time_stamp", "timestamp", "offset_time")
"""Names of fields of rings and of times: Velodyne, Ouster, Hesai, Livox and Robosense drivers differ."""
UNITS_S = (1.0, 1e-3, 1e-6, 1e-9)
"""Units of the times of points [s]: seconds to nanoseconds."""
LONGEST_SWEEP_S = 2.0
"""[s] Longest sweep: LIDARs take 0.02 to 0.2 s. Units differ by 1000, so that one unit fits the times of a sweep."""


def sweep_of_table(table: npt.NDArray[np.void], time: float, unit: int, time_unit_s: float | None = None) -> Sweep:
    """Return the points of a structured array (N,). Missing returns, NaN or at the origin, are left out.

    Parameters
    ----------
    table
        Fields `x`, `y`, `z` [m], and as far as present one of `RING_NAMES` and one of `TIME_NAMES`.
    time
        Time of the sweep [s].
    unit
        Number of the LIDAR.
    time_unit_s
        See `ReadOptions.time_unit_s`.

    Raises
    ------
    InputError
        A coordinate is missing, a point has several values of a field, or the times are not those of a sweep.
    """
    names = table.dtype.names or ()
    if missing := [name for name in "xyz" if name not in names]:
        raise InputError(f"points have no field {missing[0]}; they have {', '.join(names) or 'none'}")
    ringed, timed = (next((name for name in known if name in names), None) for known in (RING_NAMES, TIME_NAMES))
    for name in filter(None, (*"xyz", ringed, timed)):
        if table[name].ndim > 1:
            raise InputError(f"points have {table[name].shape[1]} values of field {name}; write one")
    with np.errstate(invalid="ignore"):  # damaged bytes may be signalling NaNs, and rings that are no numbers
        points = np.column_stack([table[name].astype(np.float64) for name in "xyz"])
        ring = table[ringed].astype(np.int64) if ringed else None
    kept = np.isfinite(points).all(axis=1) & (points != 0.0).any(axis=1)
    offset = _time_offset(timed, table[timed], time, time_unit_s) if timed else np.zeros(len(points))
    return Sweep(time, unit, points, offset, ring).subset(kept & np.isfinite(offset))


def _time_offset(name: str, values: npt.NDArray[Any], time: float, time_unit_s: float | None) -> Floats:
    """Return times (N,) after that of the sweep [s]; NaN stays NaN.

    Integers are nanoseconds. Floats have the largest unit by which the sweep is not too long. Times on a clock become
    offsets from the time of the sweep, or from the first point if the sweep has another clock.
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return np.full(len(values), np.nan)
    span = float(finite.max()) - float(finite.min())
    units_s = UNITS_S[-1:] if values.dtype.kind in "iu" else UNITS_S
    units_s = (time_unit_s,) if time_unit_s else units_s
    unit_s = next((unit_s for unit_s in units_s if span * unit_s <= LONGEST_SWEEP_S), None)
    if unit_s is None:
        raise InputError(
            f"the times of the points, field {name}, span {span * units_s[-1]:.3g} s in units of {units_s[-1]:g} s; a "
            f"sweep takes at most {LONGEST_SWEEP_S:g} s: give the unit by --time-unit, and each sweep in a message or "
            "file of its own"
        )
    first_s = float(finite.min()) * unit_s
    if first_s <= LONGEST_SWEEP_S:
        return values.astype(np.float64) * unit_s
    start = time / unit_s if abs(first_s - time) <= LONGEST_SWEEP_S else float(finite.min())
    return np.asarray((values.astype(np.float64) - start) * unit_s)


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
    time_unit_s: float | None = None
    """See `ReadOptions.time_unit_s`."""

    @property
    def count(self) -> int | None:
        """Number of files."""
        return len(self.paths)

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the points of each file."""
        for number, path in enumerate(self.paths):
            with readable(path, self.what):
                sweep = sweep_of_table(self.read(path), number * self.period_s, 0, self.time_unit_s)
            yield sweep

    def poses(self, name: str) -> PoseList:
        """Raise an InputError: these files hold no poses."""
        raise InputError(f"{self.paths[0]}: {name}: files of points hold no poses; leave --odometry and --truth out")

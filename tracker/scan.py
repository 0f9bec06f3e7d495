"""Input contract of the tracker: one sweep of all units, as delivered by the rig's fusion unit.

Ego frame: origin at the ego's box centre on the ground, x forward, y left, z up.
Odometry frame: fixed to the ground, starts as the ego frame of the first scan.
"""

from dataclasses import dataclass
from enum import IntFlag
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Floats, Floats32

COLUMNS: dict[str, np.dtype[Any]] = {
    "time_offset": np.dtype(np.float32),
    "unit": np.dtype(np.uint8),
    "layer": np.dtype(np.uint8),
    "echo": np.dtype(np.uint8),
    "echo_pulse_width": np.dtype(np.float32),
    "flags": np.dtype(np.uint16),
}
"""Columns of a scan beside the position of each point, with their types."""


class PointFlag(IntFlag):
    """Flags that a unit sets on a point (IBEO LUX scan 0x2202, flags byte)."""

    TRANSPARENT = 0x01
    """The beam has another echo behind this one."""
    CLUTTER = 0x02
    """An echo from the air: rain, spray, dust."""
    GROUND = 0x04
    DIRT = 0x08


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Points of one sweep of the whole rig. It has no actor ids: ground truth never enters the tracker.

    Echoes of one beam follow one another, the nearest first.
    """

    time: float
    """[s] on the clock of the rig."""
    ego_pose_odom: Floats
    """(3,) x [m], y [m], yaw [rad] of the ego frame in the odometry frame."""
    points_ego: Floats32
    """(N, 3) x, y, z in the ego frame of the point's own time [m]."""
    time_offset: Floats32
    """(N,) the point's own time minus `time` [s]."""
    unit: npt.NDArray[np.uint8]
    """(N,) index of the unit in the rig."""
    layer: npt.NDArray[np.uint8]
    """(N,) 0 is the lowest."""
    echo: npt.NDArray[np.uint8]
    """(N,) 0 is the nearest echo of its beam."""
    echo_pulse_width: Floats32
    """(N,) [m]."""
    flags: npt.NDArray[np.uint16]
    """(N,) `PointFlag`."""
    sweep_limits: Floats32 | None = None
    """(U, L, 2) time offsets of the first and the last beam of each layer of each unit, the edges of its field of view
    [s]; NaN for layers that a unit lacks. None if they are unknown."""
    unit_positions_ego: Floats | None = None
    """(U, 2) x and y of the units [m]. None if they are unknown: faces are then seen from the ego's centre."""

    def __len__(self) -> int:
        return len(self.unit)

    @classmethod
    def from_points(
        cls,
        time: float,
        points_ego: npt.ArrayLike,
        ego_pose_odom: npt.ArrayLike = (0.0, 0.0, 0.0),
        *,
        time_offset: npt.ArrayLike = 0.0,
        unit: npt.ArrayLike = 0,
        layer: npt.ArrayLike = 0,
        echo: npt.ArrayLike = 0,
        echo_pulse_width: npt.ArrayLike = 0.0,
        flags: npt.ArrayLike = 0,
    ) -> "Scan":
        """Make a scan of points (N, 3) and a pose (3,), given as arrays or lists of any numeric type.

        The attributes of points are arrays (N,), or one value for all. By default points are first echoes without
        flags, of one unit and one layer, at the scan's time. Without a pose the ego is stationary.

        Raises
        ------
        ValueError
            A shape is wrong, or a value is outside the range of its type in the record.
        """
        points = np.array(points_ego, dtype=np.float32, ndmin=1)
        if points.shape == (0,):
            points = points.reshape(0, 3)
        given = (time_offset, unit, layer, echo, echo_pulse_width, flags)
        columns = {name: _column(name, values, len(points)) for name, values in zip(COLUMNS, given, strict=True)}
        scan = cls(float(time), np.array(ego_pose_odom, dtype=np.float64), points, **columns)
        scan.check()
        return scan

    def check(self) -> None:
        """Raise ValueError for a record that breaks the contract: wrong shapes or types, or a non-finite time or pose.

        Floats and integers may be of any width. Points need not be finite.
        """
        if not np.isfinite(self.time):
            raise ValueError(f"time is {self.time}; give the clock's seconds")
        _require("ego_pose_odom", self.ego_pose_odom, (3,), "fiu")
        if not np.isfinite(self.ego_pose_odom).all():
            raise ValueError(
                f"ego_pose_odom at {self.time} s is {self.ego_pose_odom}; give x [m], y [m] and yaw [rad], "
                "extrapolated from the last poses where odometry fails"
            )
        count = np.shape(self.points_ego)[:1]
        _require("points_ego", self.points_ego, (*count, 3), "f")
        for name, dtype in COLUMNS.items():
            _require(name, getattr(self, name), count, "f" if dtype.kind == "f" else "iu")
        if self.sweep_limits is not None:
            self._check_sweep_limits(self.sweep_limits)
        if self.unit_positions_ego is not None:
            self._check_unit_positions(self.unit_positions_ego)

    def _check_sweep_limits(self, limits: Floats32) -> None:
        """Raise ValueError for fields of view (U, L, 2) that lack a unit or a layer of the points."""
        _require("sweep_limits", limits, (*np.shape(limits)[:2], 2), "f")
        for name, column, size in zip(("unit", "layer"), (self.unit, self.layer), limits.shape, strict=False):
            if len(self) and column.max() >= size:
                raise ValueError(
                    f"sweep_limits has {size} {name}s and a point is of {name} {column.max()}; give the limits of all "
                    "units and layers, or None"
                )

    def _check_unit_positions(self, positions: Floats) -> None:
        """Raise ValueError for positions (U, 2) that are not finite or lack a unit of the points."""
        _require("unit_positions_ego", positions, (*np.shape(positions)[:1], 2), "f")
        if not np.isfinite(positions).all():
            raise ValueError("unit_positions_ego has a value that is not finite; give x and y of all units, or None")
        if len(self) and self.unit.max() >= len(positions):
            raise ValueError(
                f"unit_positions_ego has {len(positions)} units and a point is of unit {self.unit.max()}; give the "
                "positions of all units, or None"
            )


def _require(name: str, values: object, shape: tuple[int, ...], kinds: str) -> None:
    """Raise ValueError for a value that is not an array of this shape and kind of number."""
    array = values if isinstance(values, np.ndarray) else None
    if array is None or array.shape != shape or array.dtype.kind not in kinds:
        found = type(values).__name__ if array is None else f"{array.dtype} {array.shape}"
        wanted = "floats" if "f" in kinds else "whole numbers"
        raise ValueError(f"{name} is {found}; give an array {shape} of {wanted}, as Scan.from_points makes it")


def _column(name: str, values: npt.ArrayLike, count: int) -> npt.NDArray[Any]:
    """Return (count,) values in the type of a column; a single value applies to all points."""
    given, dtype = np.asarray(values), COLUMNS[name]
    if given.shape not in ((), (count,)):
        raise ValueError(f"{name} has shape {given.shape}; give one value, or one for each of the {count} points")
    with np.errstate(invalid="ignore"):  # NaN in an integer column: reported below
        column = np.full(count, given).astype(dtype)
    if dtype.kind == "u" and np.any(column != given):
        largest = 2 ** (8 * dtype.itemsize) - 1
        raise ValueError(f"{name} holds values outside {dtype}; give whole numbers from 0 to {largest}")
    return np.asarray(column)

"""Files of one sweep each: PCD, and KITTI's `.bin` of float32 x, y, z, intensity."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.pcd_points import read_pcd
from luxloop.scenarios.recordings.formats.point_fields import sweep_of_table
from luxloop.scenarios.recordings.formats.reading_errors import readable
from luxloop.scenarios.recordings.sweep import PoseList, Sweep

KITTI = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity")])
FARTHEST_M = 10_000.0
"""[m] Coordinates beyond show a file of another layout."""


@dataclass(frozen=True, slots=True)
class PointFiles:
    """Files in the order of time, as a `RecordingSource`."""

    paths: list[Path]
    name: str
    """Format: `pcd` or `bin`."""
    period_s: float
    """Time between two files [s]."""

    @classmethod
    def open(cls, paths: list[Path], name: str, rate_hz: float) -> "PointFiles":
        """Take files as sweeps of a constant rate [1/s]."""
        return cls(paths, name, 1.0 / rate_hz)

    @property
    def count(self) -> int | None:
        """Number of files."""
        return len(self.paths)

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the points of each file."""
        for number, path in enumerate(self.paths):
            with readable(path, "PCD" if self.name == "pcd" else "KITTI points"):
                table = read_pcd(path) if self.name == "pcd" else _read_kitti(path)
                sweep = sweep_of_table(table, number * self.period_s, 0)
            yield sweep

    def poses(self, name: str) -> PoseList:
        """Raise an InputError: these files hold no poses."""
        raise InputError(f"{self.paths[0]}: {name}: files of points hold no poses; leave --odometry and --truth out")


def _read_kitti(path: Path) -> npt.NDArray[np.void]:
    """Return the points (N,) of a file.

    Raises
    ------
    InputError
        The file does not consist of whole points.
    """
    size = path.stat().st_size
    if size % KITTI.itemsize:
        raise InputError(
            f"{path}: {size} bytes are not whole points of {KITTI.itemsize}; it is truncated or of another format"
        )
    table = np.fromfile(path, dtype=KITTI)
    values = table.view("<f4").reshape(-1, 4)
    if not np.isfinite(values).all() or np.abs(values[:, :3]).max(initial=0.0) > FARTHEST_M:
        raise InputError(f"{path}: holds no points of float32 x, y, z, intensity; for other formats give --format")
    return table

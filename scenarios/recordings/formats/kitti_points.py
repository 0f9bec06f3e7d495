"""Format `bin`: KITTI's files of float32 x, y, z, intensity, one for each sweep."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.point_files import PointFiles

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

RECORDING_SUFFIXES = (".bin",)
KITTI = np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity")])
FARTHEST_M = 10_000.0
"""[m] Coordinates beyond show a file of another layout."""


def open_recording(paths: list[Path], options: "ReadOptions") -> PointFiles:
    """Take files as sweeps of a constant rate. See `RecordingFormat`."""
    return PointFiles(paths, read_kitti, "KITTI points", 1.0 / options.rate_hz)


def read_kitti(path: Path) -> npt.NDArray[np.void]:
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

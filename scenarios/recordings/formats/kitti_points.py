"""Format `bin`: a file of float32 for each sweep: x, y, z, intensity as of KITTI, or these and ring as of nuScenes.

The number of floats per point is found from the values: intensities are not negative, rings are whole numbers.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.point_files import PointFiles

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

RECORDING_SUFFIXES = (".bin",)
LAYOUTS = {
    count: np.dtype([(name, "<f4") for name in ("x", "y", "z", "intensity", "ring")[:count]]) for count in (4, 5)
}
"""Layout of a point by its number of floats."""
FARTHEST_M = 10_000.0
"""[m] Coordinates beyond show a file of another layout."""
RING_MAX = 255
"""Largest number of a ring."""


def open_recording(paths: list[Path], options: "ReadOptions") -> PointFiles:
    """Take files as sweeps of a constant rate. See `RecordingFormat`."""
    return PointFiles(paths, read_points, "points of float32", 1.0 / options.rate_hz)


def read_points(path: Path) -> npt.NDArray[np.void]:
    """Return the points (N,) of a file.

    Raises
    ------
    InputError
        The values fit none of `LAYOUTS`, or both.
    """
    size = path.stat().st_size
    if size % 4:
        raise InputError(f"{path}: {size} bytes are not whole float32; it is truncated or of another format")
    values = np.fromfile(path, "<f4")
    fitting = [count for count in LAYOUTS if not len(values) % count and _fits(values.reshape(-1, count))]
    if len(fitting) != 1:
        why = "points of both" if fitting else "no points of"
        raise InputError(
            f"{path}: {why} float32 x, y, z, intensity, with or without ring; write other layouts as PCD, which names "
            "its fields"
        )
    return values.view(LAYOUTS[fitting[0]])


def _fits(rows: npt.NDArray[np.float32]) -> bool:
    """Return True if the columns of rows (N, 4 or 5) can be those of a layout."""
    if not np.isfinite(rows).all() or np.abs(rows[:, :3]).max(initial=0.0) > FARTHEST_M or (rows[:, 3] < 0.0).any():
        return False
    ring = rows[:, 4:]
    return bool(((ring == np.rint(ring)) & (ring >= 0) & (ring <= RING_MAX)).all())

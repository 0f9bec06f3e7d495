"""Points of single frames, read back from a recording.

Rerun is imported lazily inside the functions, because its import takes half a second.
"""

import warnings
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.scenarios.rerun_log.blueprint import BACKGROUND
from luxloop.sensor_model.truth import Cause

if TYPE_CHECKING:
    from rerun.chunk import LazyChunkStream

PATH = "/world/ego/points"


def read_points(recording: Path, frames: Collection[int]) -> pd.DataFrame:
    """Return the points of these frames as rows `frame`, `x_ego_m`, `y_ego_m`, `on_actor`, `noise`.

    A file that rerun cannot read has none.
    """
    parts = [_rows(np.empty(0, np.int64), np.empty((0, 3), np.float32), np.empty(0, np.uint16))]
    try:
        for chunk in chunks(recording):
            if chunk.entity_path != PATH or chunk.is_static:
                continue
            batch = chunk.to_record_batch()
            for row, frame in enumerate(batch.column("frame").to_pylist()):
                if frame in frames:
                    positions = batch.column("Points3D:positions")[row].values.flatten().to_numpy()
                    classes = batch.column("Points3D:class_ids")[row].values.to_numpy()
                    xyz = positions.reshape(-1, 3)
                    parts.append(_rows(np.full(len(xyz), frame, np.int64), xyz, classes))
    except (OSError, RuntimeError, ValueError):  # damaged, or of another version of rerun
        pass
    return pd.concat(parts, ignore_index=True)


def chunks(recording: Path) -> "LazyChunkStream":
    """Return the chunks of a recording, in the order of the file, which may have no index."""
    from rerun.chunk import RrdReader
    from rerun.error_utils import RerunWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RerunWarning)  # a long recording has no index
        return RrdReader(recording).stream()


def _rows(frame: npt.NDArray[np.int64], xyz: npt.NDArray[np.float32], classes: npt.NDArray[np.uint16]) -> pd.DataFrame:
    clean = classes == Cause.CLEAN
    noise = ~clean & (classes != BACKGROUND)
    columns = {"frame": frame, "x_ego_m": xyz[:, 0], "y_ego_m": xyz[:, 1], "on_actor": clean, "noise": noise}
    return pd.DataFrame(columns)

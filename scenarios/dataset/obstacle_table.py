"""File of the static obstacles of a data set: a row per corner, once for all frames."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from luxloop.scenarios.dataset.dataset_columns import OBSTACLES
from luxloop.sim.world import Obstacles

FILE = "obstacles.parquet"


def write(folder: Path, obstacles: Obstacles) -> None:
    """Write the file.

    Raises
    ------
    OSError
        It cannot be written.
    """
    obstacle = np.repeat(np.arange(len(obstacles)), np.diff(obstacles.offset))
    values = {
        "obstacle": obstacle,
        "x_world_m": obstacles.vertices_world[:, 0],
        "y_world_m": obstacles.vertices_world[:, 1],
        "base_m": obstacles.base[obstacle],
        "top_m": obstacles.height[obstacle],
        "reflectivity": obstacles.reflectivity[obstacle],
    }
    schema = pa.schema([column.field for column in OBSTACLES])
    arrays = [column.array(values[column.name]) for column in OBSTACLES]
    pq.write_table(pa.Table.from_arrays(arrays, schema=schema), folder / FILE, compression="zstd")


def read(folder: Path) -> Obstacles:
    """Return the obstacles: the exact inverse of `write`; none if the file does not exist, as in older data sets.

    Raises
    ------
    OSError, ValueError, KeyError, pyarrow.ArrowException
        The file is damaged.
    """
    path = folder / FILE
    if not path.exists():
        return Obstacles.from_polygons([], [])
    table = pq.read_table(path)
    rows = {column.name: column.values(table[column.name].combine_chunks()) for column in OBSTACLES}
    obstacle = rows["obstacle"]
    if len(obstacle) and (obstacle[0] != 0 or not np.isin(np.diff(obstacle), (0, 1)).all()):
        raise ValueError("column obstacle: should count from 0, without gaps")
    first = np.flatnonzero(np.diff(obstacle, prepend=-1))
    return Obstacles(
        vertices_world=np.column_stack([rows["x_world_m"], rows["y_world_m"]]),
        offset=np.append(first, len(obstacle)).astype(np.int64),
        base=rows["base_m"][first],
        height=rows["top_m"][first],
        reflectivity=rows["reflectivity"][first],
    )

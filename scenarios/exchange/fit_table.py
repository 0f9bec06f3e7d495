"""Reader of rectangles that a program fitted to single frames: boxes without ids, in CSV or Parquet."""

from pathlib import Path

import numpy as np

from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange import tabular_boxes
from luxloop.scenarios.exchange.box_table import BoxTable, Texts
from luxloop.scenarios.exchange.file_formats import recognise
from luxloop.scenarios.offline.track_columns import read_table, require

METHOD = "method"
"""Column with the name of the method of each rectangle; without it, all are of one."""
ONE_METHOD = "all"


def read(path: Path) -> tuple[list[BoxTable], Texts]:
    """Return the rectangles, once for each frame of reference; their ids are the rows in the method names (N,).

    Raises
    ------
    TracksError
        The file is neither CSV nor Parquet, lacks a column, or has an invalid cell.
    """
    found = recognise(path)
    if found not in ("csv", "parquet"):
        raise TracksError(f"{path}: is of the format {found}; give fits as CSV or Parquet")
    table = read_table(path, parquet=found == "parquet")
    rows = table.drop(columns=["status", *tabular_boxes.IDS], errors="ignore").assign(id=np.arange(len(table)))
    if METHOD not in table:
        return tabular_boxes.boxes_of(path, rows), np.full(len(table), ONE_METHOD)
    cells = table[METHOD]
    require(path, cells, ~cells.isna().to_numpy(np.bool_), "give the name of the method")
    return tabular_boxes.boxes_of(path, rows), np.array([str(cell) for cell in cells], np.str_)

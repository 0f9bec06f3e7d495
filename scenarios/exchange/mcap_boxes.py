"""Reader of true boxes and tracks in the MCAP files of `luxloop mcap`."""

from pathlib import Path

import numpy as np

from scenarios.exchange.box_table import BoxTable, checked
from scenarios.exchange.file_role import Role
from scenarios.exchange.tabular_boxes import CONFIRMED

TOPICS: dict[Role, str] = {"truth": "/truth/boxes", "tracks": "/tracks"}


def read(path: Path, role: Role) -> BoxTable:
    """Return the boxes of the actors, or the confirmed tracks, in the true ego frame of each scan.

    Raises
    ------
    TracksError
        The file cannot be read, or has no topic of the role.
    """
    from scenarios.offline.mcap.boxes import read_boxes

    found = read_boxes(path, TOPICS[role])
    rows = [row for row in found if row.metadata.get("status", CONFIRMED) == CONFIRMED]
    kinds = [row.metadata.get("kind", "") for row in rows]
    table = BoxTable(
        source=path,
        axes="ego",
        id=np.array([row.id for row in rows], np.str_),
        boxes=np.array([row.box for row in rows], np.float64).reshape(-1, 5),
        frame=np.array([row.frame for row in rows], np.int64),
        time_s=np.array([row.time_s for row in rows], np.float64),
        height_m=np.array([row.height_m for row in rows], np.float64),
        kind=np.array(kinds, np.str_) if role == "truth" else None,
    )
    return checked(table, lambda row: f"{TOPICS[role]}, frame {rows[row].frame}, {rows[row].id}")

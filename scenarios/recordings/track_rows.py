"""File of tracks of a recording, in the layout that `luxloop grade --tracks` reads, with velocities."""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.tracker.records import Status, Tracks

NAMES = np.array([status.name.lower() for status in Status])
COLUMNS = (
    "frame", "time_s", "track_id", "x_odom_m", "y_odom_m", "heading_odom_rad", "length_m", "width_m", "status",
    "vx_odom_mps", "vy_odom_mps", "speed_mps",
)  # fmt: skip


class TrackRows:
    """Collects the tracks of all scans."""

    def __init__(self) -> None:
        self._rows: list[dict[str, npt.NDArray[Any]]] = []

    def add(self, frame: int, time: float, tracks: Tracks) -> None:
        """Add the tracks of one scan; terminated ones are left out."""
        kept = tracks.status != Status.DEAD
        center, velocity = tracks.center_odom[kept], tracks.mean[kept, 2:4]
        values = (
            np.full(len(center), frame), np.full(len(center), time), tracks.id[kept], *center.T, tracks.mean[kept, 6],
            *tracks.size[kept].T, NAMES[tracks.status[kept]], *velocity.T, np.hypot(*velocity.T),
        )  # fmt: skip
        self._rows.append(dict(zip(COLUMNS, values, strict=True)))

    def table(self) -> pd.DataFrame:
        """Return a row per track and scan."""
        return pd.DataFrame({name: np.concatenate([rows[name] for rows in self._rows]) for name in COLUMNS})


def write(path: Path, table: pd.DataFrame) -> None:
    """Write the file; the first columns are those that `luxloop grade --tracks` reads."""
    table.to_parquet(path, index=False)


def lives(table: pd.DataFrame) -> pd.DataFrame:
    """Return a row per track that was confirmed, in the order of appearance.

    `first_s` and `life_s` are the time of confirmation and the time until its last scan [s]; `scans` counts its
    confirmed scans; length, width and speed are medians, `speed_max_mps` is the 95th percentile, over these.
    """
    confirmed = table[table["status"] == "confirmed"]
    by_track = confirmed.groupby("track_id")
    found = by_track.agg(
        first_s=("time_s", "min"), last_s=("time_s", "max"), scans=("frame", "size"), length_m=("length_m", "median"),
        width_m=("width_m", "median"), speed_mps=("speed_mps", "median"),
    )  # fmt: skip
    found["speed_max_mps"] = by_track["speed_mps"].quantile(0.95)
    found["life_s"] = found["last_s"] - found["first_s"]
    return found.sort_values("first_s", kind="stable").reset_index()

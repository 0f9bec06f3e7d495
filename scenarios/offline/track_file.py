"""Tracks from a file of another program, as a device under test for recorded scans."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.offline import track_columns
from luxloop.tracker.records import Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import TrackerConfig

TIME_TOLERANCE_S = 1e-3
"""[s] Tolerance between the time of a row and of its scan: programs round times."""


class TrackFile:
    """Device under test that returns the tracks of a file for each scan.

    Parameters
    ----------
    path
        Path of the file.
    time_s
        (F,) times of the scans [s].

    Raises
    ------
    TracksError
        The file has an invalid layout, or belongs to other scans.
    """

    def __init__(self, path: Path, time_s: Floats) -> None:
        rows = track_columns.read(path)
        frame = _frames(path, rows, time_s)
        _refuse_duplicates(path, rows["track_id"].to_numpy(), frame)
        order = np.argsort(frame, kind="stable")
        ends = np.searchsorted(frame[order], np.arange(1, len(time_s)))
        self._tracks_by_frame: Iterator[pd.DataFrame] = iter([rows.iloc[part] for part in np.split(order, ends)])

    def as_device(self, _config: TrackerConfig) -> "TrackFile":
        """Return this object; a `luxloop.scenarios.run.device.DeviceFactory`."""
        return self

    def step(self, scan: Scan) -> Tracks:
        """Return the tracks of the next scan."""
        del scan  # the file has all of its tracks
        return _tracks(next(self._tracks_by_frame))


def _frames(path: Path, rows: pd.DataFrame, time_s: Floats) -> Ints:
    """Return (N,) frame number of each row."""
    if "frame" in rows:
        frame: Ints = rows["frame"].to_numpy()
        known = (frame >= 0) & (frame < len(time_s))
        track_columns.require(path, rows["frame"], known, f"the run has frames 0 to {len(time_s) - 1}")
        return frame
    time = rows["time_s"].to_numpy()
    nearest: Ints = np.searchsorted(0.5 * (time_s[1:] + time_s[:-1]), time)
    near = np.abs(time - time_s[nearest]) <= TIME_TOLERANCE_S
    track_columns.require(path, rows["time_s"], near, "no scan is within 1 ms of it; see time_s in scans.parquet")
    return nearest


def _refuse_duplicates(path: Path, track_id: Ints, frame: Ints) -> None:
    duplicate = pd.DataFrame({"frame": frame, "track_id": track_id}).duplicated().to_numpy(np.bool_)
    if duplicate.any():
        row = int(np.argmax(duplicate))
        raise TracksError(
            f"{path}: column track_id, row {row + 1}: {track_id[row]}: occurs twice in frame {frame[row]}; "
            "give each track one row per frame"
        )


def _tracks(rows: pd.DataFrame) -> Tracks:
    """Return the rows of a frame as tracks."""
    return Tracks.from_boxes(
        rows["track_id"].to_numpy(),
        rows[["x_odom_m", "y_odom_m"]].to_numpy(),
        rows["heading_odom_rad"].to_numpy(),
        rows[["length_m", "width_m"]].to_numpy(),
        velocity=rows[["vx_odom_mps", "vy_odom_mps"]].to_numpy(),
        status=rows["status"].to_numpy(),
        small=rows["small"].to_numpy() if "small" in rows else None,
    )

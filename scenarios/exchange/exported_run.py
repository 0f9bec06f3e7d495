"""Data of a recorded run as exporters need them, independent of the format."""

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np
import pandas as pd

from luxloop.arrays import Floats32
from luxloop.scenarios.exchange.tabular_boxes import CONFIRMED
from luxloop.scenarios.files import atomic_file, atomic_folder
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.tracker.scan import Scan


class RunFormat(Protocol):
    """Format of exported runs, a plug-in of the group `luxloop.formats`."""

    def export(self, run: RecordedRun, folder: Path) -> None:
        """Write the whole run into an empty folder."""
        ...


def write_folder(run: RecordedRun, out: Path, format_: RunFormat) -> None:
    """Write a run into a new folder, which appears as a whole or not at all.

    Raises
    ------
    OutputError
        The run has no scans, or the folder exists, is the run, or cannot be written.
    """
    run.refuse_to_write_to(out)
    with atomic_folder.create(out, "--out", atomic_folder.refuse_existing) as folder, atomic_file.writing(out):
        format_.export(run, folder)


def confirmed_tracks(run: RecordedRun) -> Mapping[int, pd.DataFrame]:
    """Return the confirmed rows of the track table by frame."""
    tracks = run.result.tables["tracks"]
    return dict(list(tracks[tracks["status"] == CONFIRMED].groupby("frame")))


def cloud(scan: Scan, *others: Floats32) -> Floats32:
    """(N, 4 + k) float32 positions in the ego frame [m], echo pulse width [m] as intensity, and other columns."""
    columns = [*scan.points_ego.T, scan.echo_pulse_width, *others]
    return np.ascontiguousarray(np.column_stack(columns), "<f4")

"""Plots of a recording of several trackers: missed vehicles and false tracks of each over time."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import pandas as pd

from luxloop.scenarios.recording.archetypes import Color
from luxloop.scenarios.result import Result

if TYPE_CHECKING:
    import rerun as rr

MISSED, FALSE = "plots/missed", "plots/false"


def log_counts(stream: "rr.RecordingStream", results: Mapping[str, Result], colors: list[Color]) -> None:
    """Log how many graded vehicles each tracker misses, and how many false tracks it has."""
    import rerun as rr

    for path in (MISSED, FALSE):
        stream.log(path, rr.SeriesLines(names=list(results), colors=colors, widths=1.5), static=True)
    truth = next(iter(results.values())).tables["truth"]
    times = truth.drop_duplicates("frame")[["frame", "time_s"]]
    counts = {
        MISSED: [_missed(result) for result in results.values()],
        FALSE: [_false(result) for result in results.values()],
    }
    for frame, time_s in times.itertuples(index=False):
        stream.set_time("frame", sequence=int(frame))
        stream.set_time("sim_time", duration=float(time_s))
        for path, of_trackers in counts.items():
            stream.log(path, rr.Scalars([float(count.get(frame, 0)) for count in of_trackers]))


def _missed(result: Result) -> dict[int, int]:
    truth = result.tables["truth"]
    return _per_frame(truth[truth["graded"] & (truth["track_id"] < 0)])


def _false(result: Result) -> dict[int, int]:
    tracks = result.tables["tracks"]
    return _per_frame(tracks[tracks["verdict"] == "false"])


def _per_frame(rows: pd.DataFrame) -> dict[int, int]:
    count = rows.groupby("frame").size()
    return dict(zip(count.index.tolist(), count.tolist(), strict=True))

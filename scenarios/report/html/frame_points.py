"""Points of the frames that a page shows: those kept with the run's worst frames, and those of its recording."""

from collections.abc import Collection
from pathlib import Path

import pandas as pd

from luxloop.scenarios.rerun_log.recorded_points import read_points
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder
from luxloop.sensor_model.truth import NO_ACTOR

COLUMNS = ["frame", "x_ego_m", "y_ego_m", "on_actor", "noise"]


def frame_points(folder: Path, result: Result, frames: Collection[int]) -> pd.DataFrame:
    """Return the points of these frames as rows of `COLUMNS`, as far as the run has them.

    A run keeps the points of few frames in its tables; its recording, if there is one, has those of all frames.
    """
    wanted = set(frames)
    kept = _kept(result, wanted)
    missing = wanted - set(kept["frame"])
    recording = folder / run_folder.RECORDING
    if not missing or not recording.is_file():
        return kept
    return pd.concat([kept, read_points(recording, missing)], ignore_index=True)


def _kept(result: Result, frames: Collection[int]) -> pd.DataFrame:
    points = result.tables.get("snapshot_points")
    if points is None:
        return pd.DataFrame(columns=COLUMNS)
    points = points[points["frame"].isin(frames)]
    seen = points.assign(on_actor=points["actor_id"] != NO_ACTOR, noise=points["cause"] != "clean")
    return seen[COLUMNS]

"""Choice of the frames that a page shows: the worst ones of failed metrics, then those of each kind of error."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.grading.worst_frames import WorstFrame
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


NAMES = {
    "detection": "Missed or false",
    "identity": "Changed identity",
    "track_heading": "Track heading",
    "fit_heading": "Fit heading",
}
"""Titles by kind of snapshot, the most serious kind first."""

SAME_PLACE_M = 0.5
"""Errors of a frame that are nearer to each other are shown once [m]."""
POSE_WORLD = ["x_world_m", "y_world_m", "yaw_world_rad"]


@dataclass(slots=True)
class ShownFrame:
    """A frame with the errors that a page shows in it."""

    frame: int
    time_s: float
    titles: list[str] = field(default_factory=list)
    """Metrics or kinds of errors that the frame is among the worst of."""
    errors: list[str] = field(default_factory=list)
    """Descriptions of the errors."""
    places_ego: list[Floats] = field(default_factory=list)
    """(2,) positions of the errors in the ego frame [m]."""

    def add(self, title: str, error: str, places_ego: Sequence[Floats]) -> None:
        """Add an error; one in the place of another one only adds its title."""
        if title not in self.titles:
            self.titles.append(title)
        known = any(np.hypot(*(old - new)) < SAME_PLACE_M for old in self.places_ego for new in places_ego)
        if error not in self.errors and not known:
            self.errors.append(error)
            self.places_ego.extend(places_ego)


def shown_frames(
    result: Result, worst: Mapping[str, Sequence[WorstFrame]], least: int, most: int
) -> dict[int, ShownFrame]:
    """Return frames by number, the worst ones first.

    Parameters
    ----------
    worst
        Worst frames of each failed metric.
    least
        Snapshots are added until there are so many frames.
    most
        Largest number of frames; the worst frame of each metric comes before the second ones.
    """
    chosen: dict[int, ShownFrame] = {}
    depth = max(map(len, worst.values()), default=0)
    for rank in range(depth):
        for metric, frames in worst.items():
            if rank < len(frames) and (frames[rank].frame in chosen or len(chosen) < most):
                found = frames[rank]
                shown = chosen.setdefault(found.frame, ShownFrame(found.frame, found.time_s))
                shown.add(metric, found.what, _places(result, found))
    for snapshot in _snapshots(result):
        if snapshot.frame in chosen or len(chosen) < least:
            shown = chosen.setdefault(snapshot.frame, ShownFrame(snapshot.frame, snapshot.time_s))
            for error in snapshot.errors:
                shown.add(snapshot.titles[0], error, snapshot.places_ego)
    return chosen


def ego_poses(result: Result) -> dict[int, Floats]:
    """Return the ego's pose and size (5,) in each frame: x, y [m], yaw [rad], length, width [m]."""
    columns = [*POSE_WORLD, "length_m", "width_m"]
    if "ego" not in result.tables:  # files of boxes
        return {}
    ego = result.tables["ego"]
    return dict(zip(ego["frame"].tolist(), ego[columns].to_numpy(np.float64), strict=True))


def _snapshots(result: Result) -> list[ShownFrame]:
    """Return the snapshots of a run, the first of every kind before the second ones."""
    if "snapshots" not in result.tables:  # files of boxes
        return []
    table = result.tables["snapshots"]
    rank = table.groupby("kind", observed=True).cumcount()
    rows = table.loc[rank.sort_values(kind="stable").index].to_dict("records")
    return [
        ShownFrame(
            row["frame"],
            row["time_s"],
            [NAMES[row["kind"]]],
            [row["what"]],
            [np.array([row["x_ego_m"], row["y_ego_m"]])],
        )
        for row in rows
    ]


def _places(result: Result, worst: WorstFrame) -> list[Floats]:
    """Return the positions of the vehicle with the error, or else of missed vehicles and false tracks."""
    truth, tracks = (_at(result.tables[name], worst.frame) for name in ("truth", "tracks"))
    if worst.actor_id != NO_ACTOR:
        wrong = truth[truth["actor_id"] == worst.actor_id][POSE_WORLD]
    else:
        missed = truth[truth["graded"] & (truth["track_id"] < 0)]
        wrong = pd.concat([missed[POSE_WORLD], tracks[tracks["verdict"] == "false"][POSE_WORLD]])
    ego = ego_poses(result).get(worst.frame)
    if ego is None or wrong.empty:
        return []
    return list(into_frame(wrong.to_numpy(np.float64), ego[:3])[:, :2])


def _at(table: pd.DataFrame, frame: int) -> pd.DataFrame:
    return table[table["frame"] == frame]

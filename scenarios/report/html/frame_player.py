"""Data of the frame player: boxes of every frame, and points of some, for the script of a page.

Lengths are whole centimetres and angles whole milliradians, in the ego frame. Points are whole decimetres, sorted, each
as its difference from the one before. The JSON text is deflated and encoded in base64, which a browser undoes without
a library.
"""

import base64
import json
import zlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.document.document import Player
from luxloop.scenarios.document.palette import TEXT_NAMES
from luxloop.scenarios.grading.articulated import angles_of, kinds_of, parts
from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.grading.worst_frames import vehicle_names
from luxloop.scenarios.report.html.shown_frames import POSE_WORLD, ShownFrame
from luxloop.scenarios.result import Result

REACH_M = 70.0
"""Boxes and points farther from the ego are left out [m]."""
SIZE = ["length_m", "width_m"]
AROUND = 12
"""Points are shown in so many frames before and after each worst frame, if the run has them: about a second."""
UNITS = np.array([100.0, 100.0, 1000.0, 100.0, 100.0])
"""Units per metre and radian of a box: x, y, heading, length, width."""


def near(shown: Iterable[int], ego: Collection[int]) -> set[int]:
    """Return the frames of a run within `AROUND` frames of the shown ones."""
    return {frame for one in shown for frame in range(one - AROUND, one + AROUND + 1) if frame in ego}


def player(
    results: Mapping[str, Result], ego: Mapping[int, Floats], marked: Sequence[ShownFrame], points: pd.DataFrame
) -> Player:
    """Return the frame player of runs of the same traffic.

    Parameters
    ----------
    results
        Runs by the name of their tracker; the truth is that of the first.
    ego
        Pose and size of the ego by frame, see `ego_poses`.
    marked
        Frames that a button leads to, the first of them shown first.
    points
        Points of some frames, see `frame_points`.
    """
    truth = next(iter(results.values())).tables["truth"]
    names = vehicle_names(truth)
    place = {actor: row for row, actor in enumerate(names)}
    times = truth.drop_duplicates("frame").set_index("frame")["time_s"]
    by_frame = {
        "truth": _split(truth, ego),
        "points": _split(points, ego),
        "tracks": [_split(result.tables["tracks"], ego) for result in results.values()],
        "fits": [_split(_selected(result.tables["fits"]), ego) for result in results.values()],
    }
    data = {
        "names": list(names.values()),
        "ego": np.round(100.0 * next(iter(ego.values()))[3:]).astype(int).tolist() if ego else [0, 0],
        "frames": [
            _frame(frame, float(times.get(frame, np.nan)), pose, by_frame, place) for frame, pose in ego.items()
        ],
        "start": marked[0].frame if marked else 0,
    }
    colors = {name: TEXT_NAMES[row % len(TEXT_NAMES)] for row, name in enumerate(results)}
    return Player(_pack(data), colors, {shown.frame: "; ".join(shown.errors) for shown in marked})


def _frame(
    frame: int, time_s: float, ego: Floats, tables: Mapping[str, Any], place: Mapping[int, int]
) -> dict[str, Any]:
    empty = pd.DataFrame()
    return {
        "n": frame,
        "t": None if np.isnan(time_s) else round(time_s, 3),
        "truth": _truth(tables["truth"].get(frame, empty), ego[:3], place),
        "tracks": [_tracks(table.get(frame, empty), ego[:3]) for table in tables["tracks"]],
        "fits": [_fits(table.get(frame, empty)) for table in tables["fits"]],
        "points": _points(tables["points"].get(frame, empty)),
    }


def _split(table: pd.DataFrame, frames: Collection[int]) -> dict[int, pd.DataFrame]:
    return {int(frame): rows for frame, rows in table.groupby("frame") if frame in frames}


def _selected(fits: pd.DataFrame) -> pd.DataFrame:
    return fits[fits["best"] & fits["heading_error_deg"].notna()]


def _truth(rows: pd.DataFrame, ego: Floats, place: Mapping[int, int]) -> list[list[int]]:
    """Return x, y, heading, length, width, number of the name (-1 for a trailer), and 1 if graded."""
    if rows.empty:
        return []
    pose = into_frame(rows[POSE_WORLD].to_numpy(np.float64), ego)
    bend, kind = angles_of(rows), kinds_of(rows["kind"])
    of, poses, sizes = parts(pose, rows[SIZE].to_numpy(np.float64), bend, kind)
    first = np.concatenate([[True], of[1:] != of[:-1]]) if len(of) else np.zeros(0, bool)
    name = np.where(first, rows["actor_id"].map(place).to_numpy()[of], -1)
    return _whole(np.hstack([poses, sizes]), name, rows["graded"].to_numpy()[of])


def _tracks(rows: pd.DataFrame, ego: Floats) -> list[list[int]]:
    """Return x, y, heading, length, width, id, 1 if confirmed, and 1 if false; tentative tracks are left out."""
    rows = rows[rows["status"].isin(("confirmed", "coasting"))] if len(rows) else rows
    if rows.empty:
        return []
    boxes = np.hstack([into_frame(rows[POSE_WORLD].to_numpy(np.float64), ego), rows[SIZE].to_numpy(np.float64)])
    return _whole(boxes, rows["track_id"], rows["status"] == "confirmed", rows["verdict"] == "false")


def _fits(rows: pd.DataFrame) -> list[list[int]]:
    """Return x, y, heading, length and width of the selected rectangles."""
    if rows.empty:
        return []
    return _whole(rows[["x_ego_m", "y_ego_m", "heading_ego_rad", *SIZE]].to_numpy(np.float64))


def _whole(boxes: Floats, *more: Any) -> list[list[int]]:
    """Return boxes (N, 5) near the ego in whole units, each with further columns."""
    seen = np.isfinite(boxes).all(axis=1) & (np.hypot(boxes[:, 0], boxes[:, 1]) < REACH_M)
    columns = [np.round(boxes[seen] * UNITS), *(np.asarray(one)[seen, None] for one in more)]
    rows: list[list[int]] = np.hstack(columns).astype(np.int64).tolist()
    return rows


def _points(rows: pd.DataFrame) -> list[list[int]]:
    """Return differences x, y, x, y, ... of the points on the background, on actors, and of noise."""
    if rows.empty:
        return []
    noise, on_actor = rows["noise"].to_numpy(bool), rows["on_actor"].to_numpy(bool)
    at = np.round(10.0 * rows[["x_ego_m", "y_ego_m"]].to_numpy(np.float64)).astype(np.int64)
    near_ego = np.hypot(at[:, 0], at[:, 1]) < 10.0 * REACH_M
    groups = (~noise & ~on_actor, ~noise & on_actor, noise)
    merged = (np.unique(at[group & near_ego], axis=0) for group in groups)
    return [np.diff(one, axis=0, prepend=[[0, 0]]).ravel().tolist() for one in merged]


def _pack(data: Mapping[str, Any]) -> str:
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).encode()
    return base64.b64encode(zlib.compress(text, 9)).decode()

"""Errors of predicted positions: the tracked corner some time ahead, by each model and by the reported estimate."""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.plane_geometry import out_of_frame, turned
from luxloop.scenarios.metrics.definitions import HORIZONS, estimates
from luxloop.tracker.records import Tracks

AROUND_S = 1.0
"""Time before and after a change of the true mode [s]; frames within count as around the change."""


def columns(models: Sequence[str]) -> list[str]:
    """Return the columns of predicted positions, in the order of `Tracks.prediction_odom`."""
    return [
        f"{estimate}_ahead_{label}_{axis}_world_m"
        for estimate, label, axis in product(estimates(models), HORIZONS, "xy")
    ]


def predicted(tracks: Tracks, row: Ints, ego_pose_odom: Floats, ego_pose_world: Floats) -> dict[str, npt.NDArray[Any]]:
    """Return the predicted corners as columns of the track table; NaN for tracks that are not judged.

    The transform from the odometry frame uses the ego poses of the time of the prediction, so that drift of the
    odometry does not count as an error of the tracker.

    Parameters
    ----------
    row
        (K,) rows of the judged tracks.
    ego_pose_odom, ego_pose_world
        (3,) ego pose in the odometry frame, as given to the tracker, and in the world.
    """
    names = columns(tracks.models)
    values = np.full((len(tracks), len(names)), np.nan)
    if tracks.prediction_odom is not None and len(row):
        ahead = tracks.prediction_odom[row].reshape(-1, 2)
        ego = turned(ahead - ego_pose_odom[:2], -ego_pose_odom[2])
        world = out_of_frame(np.column_stack([ego, np.zeros(len(ego))]), ego_pose_world)[:, :2]
        values[row] = world.reshape(len(row), -1)
    return {name: values[:, k] for k, name in enumerate(names)}


def distance(judged: pd.DataFrame, later: Floats, estimate: str, label: str) -> Floats:
    """(K,) distances of the predictions of one estimate from the true corners `later` (K, 2) [m]; NaN if unknown.

    A prediction is compared with the same corner of the true box at its time, interpolated between two frames. It is
    not graded if the vehicle has left by then. All estimates are graded in the same rows.
    """
    names = [f"{estimate}_ahead_{label}_{axis}_world_m" for axis in "xy"]
    return np.asarray(np.hypot(*(judged[names].to_numpy(np.float64) - later).T))


def errors(judged: pd.DataFrame, truth: pd.DataFrame, estimate: str, label: str) -> Floats:
    """(K,) distances of the predictions of one estimate from the true corners [m]; NaN where one is not known."""
    return distance(judged, true_corners(judged, truth, HORIZONS[label]), estimate, label)


def true_corners(judged: pd.DataFrame, truth: pd.DataFrame, ahead_s: float) -> Floats:
    """(K, 2) true positions of the tracked corners `ahead_s` [s] after each row [m]; NaN where they are not known."""
    found = np.full((len(judged), 2), np.nan)
    actor, wanted = judged["actor_id"].to_numpy(), judged["time_s"].to_numpy() + ahead_s
    sign = judged[["corner_along", "corner_across"]].to_numpy(np.float64)
    columns = ["time_s", "frame", "x_world_m", "y_world_m", "yaw_world_rad", "length_m", "width_m"]
    for actor_id, rows in _by_actor(truth[columns].to_numpy(np.float64), truth):
        mine = np.flatnonzero(actor == actor_id)
        if len(mine):
            pose = interpolated(rows[:, 0], rows[:, 1], rows[:, 2:5], wanted[mine])
            half = 0.5 * sign[mine] * rows[0, 5:]
            found[mine] = pose[:, :2] + turned(half, pose[:, 2])
    return found


def _by_actor(values: Floats, truth: pd.DataFrame) -> Iterator[tuple[int, Floats]]:
    """Yield the values (k, columns) of each actor in time order, from those of all rows of `truth` (n, columns)."""
    actor = truth["actor_id"].to_numpy()
    order = np.lexsort((truth["frame"].to_numpy(), actor))
    ids, starts = np.unique(actor[order], return_index=True)
    if len(ids):
        yield from zip(ids.tolist(), np.split(values[order], starts[1:]), strict=True)


def interpolated(known: Floats, frame: Floats, pose: Floats, time: Floats) -> Floats:
    """(K, 3) poses of one actor at times (K,) [s], linear between two successive frames; NaN elsewhere.

    Parameters
    ----------
    known, frame, pose
        (n,) times [s] and frames, and the poses (n, 3) there.
    """
    after = np.searchsorted(known, time - 1e-9)
    inside = (after > 0) & (after < len(known))
    after = np.clip(after, 1, max(len(known) - 1, 1))
    if len(known) < 2:
        return np.full((len(time), 3), np.nan)
    inside &= frame[after] - frame[after - 1] == 1
    share = (time - known[after - 1]) / (known[after] - known[after - 1])
    change = pose[after] - pose[after - 1]
    change[:, 2] = np.angle(np.exp(1j * change[:, 2]))
    return np.where(inside[:, None], pose[after - 1] + share[:, None] * change, np.nan)


def around_changes(judged: pd.DataFrame, truth: pd.DataFrame) -> Bools:
    """(K,) mask of rows within `AROUND_S` of a change of their vehicle's true mode."""
    near = np.zeros(len(judged), np.bool_)
    actor, time = judged["actor_id"].to_numpy(), judged["time_s"].to_numpy(np.float64)
    modes = np.column_stack([truth["time_s"], truth["frame"], truth["mode"].cat.codes])
    for actor_id, rows in _by_actor(modes, truth):
        mine = np.flatnonzero(actor == actor_id)
        changed, follows = np.diff(rows[:, 2]) != 0, np.diff(rows[:, 1]) == 1
        at = rows[1:, 0][changed & follows]
        if len(mine) and len(at):
            near[mine] = np.abs(time[mine, None] - at).min(axis=1) <= AROUND_S + 1e-9
    return near

"""Filters of a track: errors as in the paper's table IV, consistency of covariances, and the selected mode."""

from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.frame_tables import columns_of, rows_by_actor
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.plane_geometry import corner, matching_sign, nearest_sign, out_of_frame, turned
from luxloop.scenarios.metrics.definitions import HORIZONS, NO_PAIR, estimates
from luxloop.scenarios.result import NOT_REPORTED
from luxloop.tracker.records import MODEL_NAMES, MODELS, TURNING_MODELS, Tracks

MODE_OF = {**{model: model for model in MODELS}, **dict.fromkeys(TURNING_MODELS, "ca")}
"""True mode that each model describes: a turn is an acceleration."""

NO_MODEL = f"{NOT_REPORTED} the selected model"

STANDING_MPS = 0.5
"""[m/s] A track without a model stands below this speed: a walking person is three times as fast."""


MODE_CODES = np.array([MODELS.index(MODE_OF[model]) for model in MODEL_NAMES])
"""Index of the true mode that each model of `MODEL_NAMES` describes."""


def described_mode(model: pd.Series) -> npt.NDArray[np.int64]:
    """(K,) index in `MODELS` of the mode that each selected model describes; -1 for unknown models."""
    return np.asarray(np.append(MODE_CODES, -1)[model.cat.codes.to_numpy()], dtype=np.int64)


def column(tracks: pd.DataFrame, name: str) -> npt.NDArray[Any] | None:
    """Return a column (K,) about the selected model of judged tracks, NaN without one; None for other names.

    A track without a model stands or moves by its speed.
    """
    model = tracks["model"]
    if name == "right_mode":
        right = described_mode(model) == tracks["true_mode"].cat.codes.to_numpy()
        return np.where(model.isna(), np.nan, right)
    if name.startswith("selected_"):
        return np.where(model.isna(), np.nan, model == name.removeprefix("selected_"))
    if name != "right_motion":
        return None
    speed = np.hypot(*columns_of(tracks, ("vx_world_mps", "vy_world_mps")).T)
    stands = np.where(model.notna(), model.to_numpy(object) == MODELS[0], speed < STANDING_MPS)
    known = (model.notna() | np.isfinite(speed)).to_numpy()
    return np.where(known, stands == (tracks["true_mode"] == MODELS[0]), np.nan)


def switch_latencies(judged: pd.DataFrame) -> list[tuple[int, float]]:
    """Return the vehicle of each change of the true mode, and the frames until its selection.

    Infinite if the mode is not selected before the next change. A change counts if the vehicle is followed in the frame
    of the change and in the previous one. Rows without a selected model are left out.
    """
    latencies: list[tuple[int, float]] = []
    frames, modes = judged["frame"].to_numpy(), judged["true_mode"].cat.codes.to_numpy()
    models = described_mode(judged["model"])
    known = np.flatnonzero(models >= 0)
    for actor_id, rows in rows_by_actor(judged["actor_id"].to_numpy(), known[np.argsort(frames[known], kind="stable")]):
        frame, mode, model = frames[rows], modes[rows], models[rows]
        changes = np.flatnonzero(np.diff(mode)) + 1
        for start, stop in pairwise([*changes, len(mode)]):
            if frame[start] - frame[start - 1] == 1:
                agrees = start + np.flatnonzero(model[start:stop] == mode[start])
                wait = float(frame[agrees[0]] - frame[start]) if len(agrees) else np.inf
                latencies.append((actor_id, wait))
    return latencies


def corner_errors(
    tracks: Tracks, row: Ints, track_boxes_ego: Floats, true_boxes_ego: Floats, ego_pose_odom: Floats
) -> dict[str, npt.NDArray[Any]]:
    """Return the errors of the tracked corner as columns of the track table; NaN for tracks that are not judged.

    The corner is that of the track's `corner_sign`; the true corner follows from the nearest quarter turn between the
    two headings. A track of its box's centre is judged by the corner nearest to the ego. NEES is e' P^-1 e of a
    position (Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2), of the track and of each model.

    Parameters
    ----------
    row
        (K,) rows of the judged tracks.
    track_boxes_ego, true_boxes_ego
        (K, 5) boxes of these tracks, and of the vehicles that they follow.
    ego_pose_odom
        (3,) ego pose in the odometry frame, as given to the tracker.
    """
    turn = track_boxes_ego[:, 2] - true_boxes_ego[:, 2]
    by_center: Bools = np.asarray((tracks.corner_sign[row] == 0).all(axis=1))
    own_sign = np.where(by_center[:, None], nearest_sign(track_boxes_ego), tracks.corner_sign[row])
    true_sign = matching_sign(own_sign, turn)
    true_ego = corner(true_boxes_ego, true_sign)
    position_odom = np.concatenate([tracks.model_position_odom[row], tracks.mean[row, None, :2]], axis=1)
    position_ego = turned(position_odom - ego_pose_odom[:2], -ego_pose_odom[2])
    position_ego[by_center, -1] = corner(track_boxes_ego[by_center], own_sign[by_center])
    error_ego = position_ego - true_ego[:, None]
    error_odom = turned(error_ego, ego_pose_odom[2])

    count = len(tracks.models)
    errors = np.full((len(tracks), count + 1, 2), np.nan)
    errors[row] = error_ego
    sign = np.full((len(tracks), 2), np.nan)
    sign[row] = np.where(by_center[:, None], 0, true_sign)
    nees, nis = np.full((len(tracks), count + 1), np.nan), np.full((len(tracks), count), np.nan)
    nees[row, -1] = mahalanobis_squared(error_odom[:, -1], tracks.covariance[row, :2, :2])
    if tracks.model_covariance_odom is not None:
        nees[row, :-1] = mahalanobis_squared(error_odom[:, :-1], tracks.model_covariance_odom[row])
    if tracks.model_nis is not None:
        nis[row] = tracks.model_nis[row]
    return {
        **{
            f"{estimate}_{axis}_error_m": errors[:, e, a]
            for e, estimate in enumerate(estimates(tracks.models))
            for a, axis in enumerate("xy")
        },
        "corner_along": sign[:, 0],
        "corner_across": sign[:, 1],
        "nees": nees[:, -1],
        **{f"{model}_nees": nees[:, m] for m, model in enumerate(tracks.models)},
        **{f"{model}_nis": nis[:, m] for m, model in enumerate(tracks.models)},
    }


def mahalanobis_squared(error: Floats, covariance: Floats) -> Floats:
    """Squared Mahalanobis distance e' P^-1 e (...) of errors e (..., 2) [m] with covariances P (..., 2, 2) [m^2].

    NaN where P is NaN, infinite where P is not positive definite.
    """
    a, b, c = covariance[..., 0, 0], covariance[..., 0, 1], covariance[..., 1, 1]
    determinant = a * c - b * b
    sound = (a > 0) & (determinant > 0)
    x, y = error[..., 0], error[..., 1]
    squared = np.where(sound, (c * x * x - 2 * b * x * y + a * y * y) / np.where(sound, determinant, 1.0), np.inf)
    return np.where(np.isnan(determinant), np.nan, squared)


def corner_column(tracks: pd.DataFrame, name: str, nees_confidence: float) -> npt.NDArray[Any] | None:
    """Return a column (K,) of judged tracks that follows from others, None for other names.

    Position errors are absolute [m]. NEES and NIS have 2 degrees of freedom. A single model is graded only while it
    describes the true mode, because its covariance assumes that motion.

    Parameters
    ----------
    tracks
        Judged rows of the track table.
    name
        Name of the column, as in the definitions of the metrics.
    nees_confidence
        Probability of the chi-square band.
    """
    estimate, _, rest = name.partition("_")
    if rest in ("x_abs_error_m", "y_abs_error_m"):
        return np.asarray(np.abs(tracks[f"{estimate}_{rest[0]}_error_m"].to_numpy(np.float64)))
    if rest.startswith(("nees_", "nis_")):
        measure, _, figure = rest.partition("_")
        value = tracks[measure if estimate == "mma" else f"{estimate}_{measure}"].to_numpy(np.float64)
        low, high = band(nees_confidence)
        return value if figure == "mean" else np.where(np.isnan(value), np.nan, (low <= value) & (value <= high))
    if estimate == "describes":
        every = np.ones(len(tracks), np.bool_)
        return every if rest == "mma" else np.asarray(tracks["true_mode"] == MODE_OF[rest])
    return np.asarray(tracks["true_mode"] == rest) if estimate == "mode" else column(tracks, name)


def corner_distances(judged: pd.DataFrame, models: Sequence[str]) -> Floats:
    """(K, estimates) distances of the models' corners and, last, of the selected one from the true corner [m]."""
    errors = (columns_of(judged, [f"{one}_{axis}_error_m" for one in estimates(models)]) for axis in "xy")
    return np.asarray(np.hypot(*errors))


def grade_gain(sheet: MetricSheet, off: Floats, name: str) -> None:
    """Enter the share by which model selection lowers the mean distance from the true corner below the best model's.

    All estimates are compared over the same rows of `corner_distances` (K, estimates), those with an estimate of every
    model of the bank.
    """
    off = off[:, np.append(np.isfinite(off[:, :-1]).any(axis=0), True)]
    off = off[np.isfinite(off).all(axis=1)] if off.shape[1] > 1 else np.empty((0, 2))
    mean = off.mean(axis=0) if len(off) else np.full(off.shape[1], np.nan)
    single = float(mean[:-1].min())
    sheet.write(name, 1.0 - float(mean[-1]) / single if single > 0.0 else None, len(off), NO_PAIR)


def band(confidence: float) -> tuple[float, float]:
    """Return the two-sided band of chi-square with 2 degrees of freedom; its quantile at p is -2 ln(1 - p)."""
    tail = (1 - confidence) / 2
    return -2 * np.log1p(-tail), -2 * np.log(tail)


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
    predicted = columns_of(judged, (f"{estimate}_ahead_{label}_{axis}_world_m" for axis in "xy"))
    return np.asarray(np.hypot(*(predicted - later).T))


def errors(judged: pd.DataFrame, truth: pd.DataFrame, estimate: str, label: str) -> Floats:
    """(K,) distances of the predictions of one estimate from the true corners [m]; NaN where one is not known."""
    return distance(judged, true_corners(judged, truth, HORIZONS[label]), estimate, label)


def true_corners(judged: pd.DataFrame, truth: pd.DataFrame, ahead_s: float) -> Floats:
    """(K, 2) true positions of the tracked corners `ahead_s` [s] after each row [m]; NaN where they are not known."""
    found = np.full((len(judged), 2), np.nan)
    actor, wanted = judged["actor_id"].to_numpy(), judged["time_s"].to_numpy() + ahead_s
    sign = columns_of(judged, ("corner_along", "corner_across"))
    columns = ["time_s", "frame", "x_world_m", "y_world_m", "yaw_world_rad", "length_m", "width_m"]
    for actor_id, rows in _by_actor(columns_of(truth, columns), truth):
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

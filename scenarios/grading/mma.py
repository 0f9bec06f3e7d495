"""How well the filters and their choice do: the paper's table of position errors, the modes, and consistency."""

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from scenarios.grading.geometry import Floats, Ints, corner, matching_sign, turned
from scenarios.grading.metrics import ESTIMATES, TARGETS
from scenarios.grading.sheet import MetricSheet
from tracker.records import MODELS, Tracks

NO_PAIR = "no confirmed track followed a graded vehicle"


def corner_errors(
    tracks: Tracks, row: Ints, track_boxes_ego: Floats, true_boxes_ego: Floats, ego_pose_odom: Floats
) -> dict[str, npt.NDArray[Any]]:
    """Errors of the tracked corner, for the table's columns; NaN where a track is not judged.

    Parameters
    ----------
    row
        (K,) rows of `tracks` that are judged.
    track_boxes_ego, true_boxes_ego
        (K, 5) their boxes and those of the vehicles they follow.

    The corner is the one the track names, found again on the true box by the nearest quarter turn of its heading.
    NEES is e' P^-1 e of the selected model's position (Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2).
    """
    turn = track_boxes_ego[:, 2] - true_boxes_ego[:, 2]
    true_ego = corner(true_boxes_ego, matching_sign(tracks.corner_sign[row], turn))
    position_odom = np.concatenate([tracks.model_position_odom[row], tracks.mean[row, None, :2]], axis=1)
    position_ego = turned(position_odom - ego_pose_odom[:2], -ego_pose_odom[2])
    error_ego = position_ego - true_ego[:, None]
    error_odom = turned(error_ego[:, -1], ego_pose_odom[2])

    errors = np.full((len(tracks), len(ESTIMATES), 2), np.nan)
    errors[row] = error_ego
    nees = np.full(len(tracks), np.nan)
    nees[row] = mahalanobis_squared(error_odom, tracks.covariance[row, :2, :2])
    columns = {
        f"{estimate}_{axis}_error_m": errors[:, e, a]
        for e, estimate in enumerate(ESTIMATES)
        for a, axis in enumerate("xy")
    }
    return {**columns, "nees": nees}


def mahalanobis_squared(error: Floats, covariance: Floats) -> Floats:
    """E' P^-1 e (K,) of errors (K, 2) [m]; infinite where P (K, 2, 2) is not positive definite."""
    a, b, c = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    determinant = a * c - b * b
    sound = (a > 0) & (determinant > 0)
    x, y = error.T
    return np.where(sound, (c * x * x - 2 * b * x * y + a * y * y) / np.where(sound, determinant, 1.0), np.inf)


def grade(sheet: MetricSheet, tracks: pd.DataFrame, nees_confidence: float) -> None:
    """Enter every `mma` metric from the track table with its `true_mode`; only judged rows count.

    An estimate that a tracker does not make is NaN and not charged.
    """
    judged = tracks[tracks["judged"]]
    standing = judged["true_mode"] == MODELS[0]
    for target, rows in zip(TARGETS, (judged[standing], judged[~standing]), strict=True):
        why = f"{NO_PAIR} that is a {target.replace('_', ' ')}"
        for estimate in ESTIMATES:
            for axis in "xy":
                error = rows[f"{estimate}_{axis}_error_m"].abs().dropna().to_numpy()
                sheet.mean(f"mma.{estimate}.{target}.{axis}_abs_mean_m", error, why)
                sheet.std(f"mma.{estimate}.{target}.{axis}_abs_std_m", error, why)
    sheet.mean("mma.mode_accuracy", (judged["model"] == judged["true_mode"]).to_numpy(), NO_PAIR)
    low, high = band(nees_confidence)
    sheet.mean("mma.nees_in_band", judged["nees"].between(low, high).to_numpy(), NO_PAIR)
    _grade_latency(sheet, switch_latencies(judged))


def band(confidence: float) -> tuple[float, float]:
    """Two-sided band of chi-square with 2 degrees of freedom: its quantile at p is -2 ln(1 - p)."""
    tail = (1 - confidence) / 2
    return -2 * np.log1p(-tail), -2 * np.log(tail)


def switch_latencies(judged: pd.DataFrame) -> Floats:
    """Frames from each true change of mode to its selection; infinite where it is not selected before the next.

    A change counts if the vehicle is followed in the frame of the change and in the one before.
    """
    latencies: list[float] = []
    for _, rows in judged.sort_values("frame", kind="stable").groupby("actor_id"):
        frame = rows["frame"].to_numpy()
        mode, model = rows["true_mode"].cat.codes.to_numpy(), rows["model"].cat.codes.to_numpy()
        changes = np.flatnonzero(np.diff(mode)) + 1
        for start, stop in pairwise([*changes, len(mode)]):
            if frame[start] - frame[start - 1] == 1:
                agrees = start + np.flatnonzero(model[start:stop] == mode[start])
                latencies.append(float(frame[agrees[0]] - frame[start]) if len(agrees) else np.inf)
    return np.array(latencies)


def _grade_latency(sheet: MetricSheet, latencies: Floats) -> None:
    why, median = "no followed vehicle changed its mode", None
    if len(latencies):
        median = float(np.median(latencies))
    if median == np.inf:
        why, median = "half of the changes of mode or more were never followed", None
    sheet.write("mma.switch_latency_frames", median, len(latencies), why)

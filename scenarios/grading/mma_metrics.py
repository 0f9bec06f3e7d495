"""How well the filters do: the paper's table of position errors, and whether they know how well they do."""

from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from scenarios.arrays import Floats, Ints
from scenarios.grading.metric_names import ESTIMATES, TARGETS
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.plane_geometry import corner, matching_sign, turned
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
    NEES is e' P^-1 e of a position (Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2): the selected model's, and each
    model's own.
    """
    turn = track_boxes_ego[:, 2] - true_boxes_ego[:, 2]
    true_ego = corner(true_boxes_ego, matching_sign(tracks.corner_sign[row], turn))
    position_odom = np.concatenate([tracks.model_position_odom[row], tracks.mean[row, None, :2]], axis=1)
    position_ego = turned(position_odom - ego_pose_odom[:2], -ego_pose_odom[2])
    error_ego = position_ego - true_ego[:, None]
    error_odom = turned(error_ego, ego_pose_odom[2])

    errors = np.full((len(tracks), len(ESTIMATES), 2), np.nan)
    errors[row] = error_ego
    nees, nis = np.full((len(tracks), len(ESTIMATES)), np.nan), np.full((len(tracks), len(MODELS)), np.nan)
    nees[row, -1] = mahalanobis_squared(error_odom[:, -1], tracks.covariance[row, :2, :2])
    if tracks.model_covariance_odom is not None:
        nees[row, :-1] = mahalanobis_squared(error_odom[:, :-1], tracks.model_covariance_odom[row])
    if tracks.model_nis is not None:
        nis[row] = tracks.model_nis[row]
    return {
        **{
            f"{estimate}_{axis}_error_m": errors[:, e, a]
            for e, estimate in enumerate(ESTIMATES)
            for a, axis in enumerate("xy")
        },
        "nees": nees[:, -1],
        **{f"{model}_nees": nees[:, m] for m, model in enumerate(MODELS)},
        **{f"{model}_nis": nis[:, m] for m, model in enumerate(MODELS)},
    }


def mahalanobis_squared(error: Floats, covariance: Floats) -> Floats:
    """E' P^-1 e (...) of errors (..., 2) [m]; NaN where P (..., 2, 2) is, infinite where it is not positive."""
    a, b, c = covariance[..., 0, 0], covariance[..., 0, 1], covariance[..., 1, 1]
    determinant = a * c - b * b
    sound = (a > 0) & (determinant > 0)
    x, y = error[..., 0], error[..., 1]
    squared = np.where(sound, (c * x * x - 2 * b * x * y + a * y * y) / np.where(sound, determinant, 1.0), np.inf)
    return np.where(np.isnan(determinant), np.nan, squared)


def grade(sheet: MetricSheet, tracks: pd.DataFrame, nees_confidence: float) -> None:
    """Enter the errors of the tracked corner and their consistency from the track table; only judged rows count.

    An estimate that a tracker does not make is NaN and not charged.
    """
    judged = tracks[tracks["judged"]]
    standing = judged["true_mode"] == MODELS[0]
    for target, rows in zip(TARGETS, (judged[standing], judged[~standing]), strict=True):
        why = f"{NO_PAIR} that is a {target.replace('_', ' ')}"
        for estimate in ESTIMATES:
            for axis in "xy":
                _grade_position(sheet, rows, f"mma.{estimate}.{target}.{axis}_abs", f"{estimate}_{axis}_error_m", why)
        _grade_gain(sheet, rows, f"mma.gain.{target}", why)
    _grade_consistency(sheet, judged, nees_confidence)


def _grade_position(sheet: MetricSheet, rows: pd.DataFrame, prefix: str, column: str, why_none: str) -> None:
    made = rows[rows[column].notna()]
    why_none = "the tracker makes no such estimate" if len(rows) else why_none
    error, vehicle = made[column].abs().to_numpy(), made["actor_id"].to_numpy()
    sheet.mean(f"{prefix}_mean_m", error, why_none, vehicle)
    sheet.std(f"{prefix}_std_m", error, why_none, vehicle)


def _grade_gain(sheet: MetricSheet, rows: pd.DataFrame, name: str, why_none: str) -> None:
    """Enter by what share the selection's distance from the true corner is below that of the best single model.

    All are judged in the same frames: those in which every model makes an estimate.
    """
    off = np.hypot(
        *(rows[[f"{estimate}_{axis}_error_m" for estimate in ESTIMATES]].to_numpy(np.float64) for axis in "xy")
    )
    off = off[np.isfinite(off).all(axis=1)]
    mean = off.mean(axis=0) if len(off) else np.full(len(ESTIMATES), np.nan)
    single = float(mean[:-1].min())
    sheet.write(name, 1.0 - float(mean[-1]) / single if single > 0.0 else None, len(off), why_none)


def _grade_consistency(sheet: MetricSheet, judged: pd.DataFrame, confidence: float) -> None:
    """Enter NEES and NIS, with 2 degrees of freedom.

    A single model is held against its covariance only while the vehicle truly moves that way: it promises nothing else.
    """
    why = "the tracker does not tell its covariance" if len(judged) else NO_PAIR
    _grade_band(sheet, judged, "nees", "mma.nees", why, confidence)
    for model, measure in product(MODELS, ("nees", "nis")):
        rows = judged[judged["true_mode"] == model]
        why = (
            f"the tracker does not tell the {measure} of its models" if len(rows) else f"{NO_PAIR} in the mode {model}"
        )
        _grade_band(sheet, rows, f"{model}_{measure}", f"mma.{model}.{measure}", why, confidence)


def _grade_band(
    sheet: MetricSheet, rows: pd.DataFrame, column: str, prefix: str, why_none: str, confidence: float
) -> None:
    """Enter the share within the chi-square band, and the mean, which should be 2 (of the finite)."""
    told = rows[rows[column].notna()]
    low, high = band(confidence)
    value, vehicle = told[column].to_numpy(), told["actor_id"].to_numpy()
    sheet.mean(f"{prefix}_in_band", (low <= value) & (value <= high), why_none, vehicle)
    finite = np.isfinite(value)
    sheet.mean(f"{prefix}_mean", value[finite], why_none, vehicle[finite])


def band(confidence: float) -> tuple[float, float]:
    """Two-sided band of chi-square with 2 degrees of freedom: its quantile at p is -2 ln(1 - p)."""
    tail = (1 - confidence) / 2
    return -2 * np.log1p(-tail), -2 * np.log(tail)

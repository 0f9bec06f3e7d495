"""Errors of rectangles fitted to single frames: heading as in the paper's tables, position, and overlap."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from scenarios.arrays import Bools, Floats, Ints
from scenarios.grading import bound
from scenarios.grading.bound import Ranging
from scenarios.grading.frame_truth import FrameTruth
from scenarios.grading.metric_names import FIT_METHODS, VIEWS
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.ownership import NO_ACTOR_ROW, Ownership
from scenarios.grading.plane_geometry import QUARTER, corner, iou, matching_sign, nearest_sign, wrap
from tracker.records import BASELINES, METHODS, StepTrace

BOX = ("x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m")
NO_BASELINES = "the tracker fitted no baselines: [tracker.baselines] enabled = true"
TRUE_BOX = ("true_x_ego_m", "true_y_ego_m", "true_yaw_ego_rad", "true_length_m", "true_width_m")


def rows(
    frame_truth: FrameTruth, ownership: Ownership, trace: StepTrace, ranging: Ranging | None
) -> dict[str, npt.NDArray[Any]]:
    """Return the fit observations of one frame: a row per candidate of each graded vehicle with a segment."""
    owner, segment = _largest_segments(ownership)
    fitted = trace.candidates
    methods = fitted.heading.shape[1]  # fitting the baselines, the last of `CANDIDATES`, is optional
    box = np.dstack([fitted.center_ego[segment], fitted.heading[segment], fitted.size[segment]]).reshape(-1, len(BOX))
    method = np.tile(np.arange(methods), len(segment))

    def each(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.repeat(values, methods, axis=0)

    columns = {
        "segment": each(segment),
        "actor_id": each(frame_truth.actors.id[owner]),
        "view": each(frame_truth.truth.view[owner]),
        "range_m": each(frame_truth.range_m[owner]),
        "points": each(ownership.size[segment]),
        "heading_bound_deg": each(
            np.degrees(bound.observed(frame_truth, ranging, trace.segments.label, owner, segment))
        ),
        "method": method,
        "cost": fitted.cost[segment].ravel(),
        "best": method == each(fitted.best[segment]),
        **dict(zip(BOX, box.T, strict=True)),
        **dict(zip(TRUE_BOX, each(frame_truth.boxes_ego[owner]).T, strict=True)),
    }
    kept = (method < len(METHODS)) | np.isfinite(box[:, 2])  # disabled baselines have no rows
    return {name: values[kept] for name, values in columns.items()}


def _largest_segments(ownership: Ownership) -> tuple[Ints, Ints]:
    """Return the owners (K,) and the segment (K,) with most points of each.

    As in the paper, a vehicle is observed once per frame. Its other segments are fragments, like a wheel seen under
    another car or the end of a bumper. They carry no heading information and count as over-segmentation.
    """
    segment = np.flatnonzero(ownership.owner != NO_ACTOR_ROW)
    owner = ownership.owner[segment]
    largest_first = np.argsort(-ownership.counts[owner, segment], kind="stable")
    owners, first = np.unique(owner[largest_first], return_index=True)
    return owners, segment[largest_first[first]]


def measure(fits: pd.DataFrame) -> pd.DataFrame:
    """Add the errors of every rectangle, and mark the least heading error of each observation as `oracle`.

    Heading errors are modulo 90 degrees, in (-45, 45]. The position error is the distance from the rectangle's corner
    nearest to the ego to the same corner of the true box. The rectangle chooses the corner: for a vehicle abreast, with
    two equally near corners, independent choices could differ by the whole length.
    """
    box, true = fits[[*BOX]].to_numpy(np.float64), fits[[*TRUE_BOX]].to_numpy(np.float64)
    turn = box[:, 2] - true[:, 2]
    error = np.degrees(wrap(turn, QUARTER))
    sign = nearest_sign(box)
    fitted = np.isfinite(error)
    gap = corner(box, sign) - corner(true, matching_sign(sign, np.where(fitted, turn, 0.0)))
    return fits.assign(
        heading_error_deg=error,
        position_error_m=np.hypot(gap[:, 0], gap[:, 1]),
        iou=iou(box, true),
        oracle=_oracle(fits["method"].cat.codes.to_numpy(), error),
    )


def _oracle(method: npt.NDArray[np.int8], error: Floats) -> Bools:
    """Mark the least error among each observation's `METHODS`; baselines are not selectable, NaN is skipped."""
    choice = np.flatnonzero(method < len(METHODS)).reshape(-1, len(METHODS))
    least = choice[np.arange(len(choice)), np.where(np.isfinite(error), np.abs(error), np.inf)[choice].argmin(axis=1)]
    oracle = np.zeros(len(error), dtype=np.bool_)
    oracle[least] = np.isfinite(error[least])
    return oracle


def grade(sheet: MetricSheet, fits: pd.DataFrame, observations: int, why_none: str) -> None:
    """Enter every `fit` metric. An observation without a rectangle of a method does not count for this method.

    Parameters
    ----------
    fits
        The table with errors.
    observations
        Observations of the data set, the denominator of the coverage; 0 for a tracker without a trace.
    why_none
        Reason of missing values.
    """
    fitted = fits[np.isfinite(fits["heading_error_deg"])]
    sheet.rate("fit.best.coverage", int(fitted["best"].sum()), observations, why_none)
    for scope in (None, *VIEWS.values()):
        seen = fitted if scope is None else fitted[fitted["view"] == scope]
        why = why_none if scope is None or not len(fitted) else f"no observation is a {scope} view"
        for method in FIT_METHODS:
            prefix = f"fit.{method}" if scope is None else f"fit.{scope}.{method}"
            unfitted = len(seen) and method in BASELINES
            _grade_method(sheet, prefix, _of_method(seen, method), NO_BASELINES if unfitted else why)
    _grade_regret(sheet, fitted, why_none)
    _grade_bound(sheet, _of_method(fitted, "best"), why_none)


def _of_method(fits: pd.DataFrame, method: str) -> pd.DataFrame:
    return fits[fits[method]] if method in ("best", "oracle") else fits[fits["method"] == method]


def _grade_method(sheet: MetricSheet, prefix: str, fits: pd.DataFrame, why_none: str) -> None:
    error, vehicle = fits["heading_error_deg"].to_numpy(), fits["actor_id"].to_numpy()
    sheet.mean(f"{prefix}.heading_mean_deg", error, why_none, vehicle)
    sheet.std(f"{prefix}.heading_std_deg", error, why_none, vehicle)
    sheet.mean(f"{prefix}.heading_abs_mean_deg", np.abs(error), why_none, vehicle)
    sheet.std(f"{prefix}.heading_abs_std_deg", np.abs(error), why_none, vehicle)
    for limit in range(1, 6):
        sheet.mean(f"{prefix}.within_{limit}deg", np.abs(error) <= limit, why_none, vehicle)
    sheet.mean(f"{prefix}.position_abs_mean_m", fits["position_error_m"].to_numpy(), why_none, vehicle)
    sheet.mean(f"{prefix}.iou_mean", fits["iou"].to_numpy(), why_none, vehicle)


def _grade_regret(sheet: MetricSheet, fitted: pd.DataFrame, why_none: str) -> None:
    """Enter the mean gain of a perfect selection among `METHODS`, over observations with a selected rectangle.

    The regret overstates the fault of the selection, because the least of several errors is partly small by chance.
    """
    of_observation = ["frame", "actor_id"]
    best, oracle = (
        _of_method(fitted, method).set_index(of_observation)["heading_error_deg"].abs() for method in ("best", "oracle")
    )
    regret = best - oracle.reindex(best.index)
    vehicle = best.index.get_level_values("actor_id").to_numpy()
    sheet.mean("fit.best.regret_deg", regret.to_numpy(), why_none, vehicle)


def _grade_bound(sheet: MetricSheet, best: pd.DataFrame, why_none: str) -> None:
    """Enter the mean absolute heading error over that of normal errors at the bound, sqrt(2 / pi) times the bound."""
    bounded = best[best["heading_bound_deg"].notna()]
    error = bounded["heading_error_deg"].abs().to_numpy()
    at_bound = np.sqrt(2.0 / np.pi) * bounded["heading_bound_deg"].to_numpy()
    why = "no observation has a bound: the range noise is zero or unknown, or no face has two clean points"
    sheet.ratio("fit.best.bound_ratio", error, at_bound, why if len(best) else why_none, bounded["actor_id"].to_numpy())

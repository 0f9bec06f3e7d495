"""How well single-frame rectangles fit: the paper's tables of heading errors, and position and overlap beside them."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from scenarios.arrays import Bools, Floats, Ints
from scenarios.grading import bound
from scenarios.grading.bound import Ranging
from scenarios.grading.frame_truth import Instant
from scenarios.grading.metric_names import FIT_METHODS, VIEWS
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.ownership import NOBODY, Ownership
from scenarios.grading.plane_geometry import QUARTER, corner, iou, matching_sign, nearest_sign, wrap
from tracker.records import BASELINES, METHODS, StepTrace

BOX = ("x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m")
NO_BASELINES = "the tracker fitted no baselines: [tracker.baselines] enabled = true"
TRUE_BOX = ("true_x_ego_m", "true_y_ego_m", "true_yaw_ego_rad", "true_length_m", "true_width_m")


def rows(now: Instant, ownership: Ownership, trace: StepTrace, ranging: Ranging | None) -> dict[str, npt.NDArray[Any]]:
    """Return the fit observations of one frame: a row per graded vehicle that has a segment, and candidate."""
    owner, segment = _largest_segments(ownership)
    fitted = trace.candidates
    methods = fitted.heading.shape[1]  # a tracker need not fit the last of `CANDIDATES`, baselines
    box = np.dstack([fitted.center_ego[segment], fitted.heading[segment], fitted.size[segment]]).reshape(-1, len(BOX))
    method = np.tile(np.arange(methods), len(segment))

    def each(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.repeat(values, methods, axis=0)

    columns = {
        "segment": each(segment),
        "actor_id": each(now.actors.id[owner]),
        "view": each(now.truth.view[owner]),
        "range_m": each(now.range_m[owner]),
        "points": each(ownership.size[segment]),
        "heading_bound_deg": each(np.degrees(bound.observed(now, ranging, trace.segments.label, owner, segment))),
        "method": method,
        "cost": fitted.cost[segment].ravel(),
        "best": method == each(fitted.best[segment]),
        **dict(zip(BOX, box.T, strict=True)),
        **dict(zip(TRUE_BOX, each(now.boxes_ego[owner]).T, strict=True)),
    }
    kept = (method < len(METHODS)) | np.isfinite(box[:, 2])  # a baseline that is off is not in the table
    return {name: values[kept] for name, values in columns.items()}


def _largest_segments(ownership: Ownership) -> tuple[Ints, Ints]:
    """Each owner (K,) and the segment (K,) that holds most of its points.

    As in the paper, a vehicle is observed once a frame. Its other segments are pieces, like a wheel seen under a car
    or the end of a bumper beside it: that they were cut off is segmentation's mistake, and they tell no heading.
    """
    segment = np.flatnonzero(ownership.owner != NOBODY)
    owner = ownership.owner[segment]
    largest_first = np.argsort(-ownership.counts[owner, segment], kind="stable")
    owners, first = np.unique(owner[largest_first], return_index=True)
    return owners, segment[largest_first[first]]


def measure(fits: pd.DataFrame) -> pd.DataFrame:
    """Add the errors of every rectangle, and mark each observation's `oracle`: the least heading error.

    Heading errors are modulo 90 degrees, in (-45, 45]. The position is that of the rectangle's corner nearest to the
    ego, against the same corner of the true box: naming the true one by the rectangle's keeps a vehicle abreast,
    whose two near corners are equally far, from costing its whole length.
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
    """Mark the least error of each observation's `METHODS`; baselines cannot be chosen, and NaN is no error."""
    choice = np.flatnonzero(method < len(METHODS)).reshape(-1, len(METHODS))
    least = choice[np.arange(len(choice)), np.where(np.isfinite(error), np.abs(error), np.inf)[choice].argmin(axis=1)]
    oracle = np.zeros(len(error), dtype=np.bool_)
    oracle[least] = np.isfinite(error[least])
    return oracle


def grade(sheet: MetricSheet, fits: pd.DataFrame, observations: int, why_none: str) -> None:
    """Enter every `fit` metric; a method that fitted no rectangle to an observation is not charged for it.

    How many of the data set's `observations` (0 for a tracker that gives no trace) have one is the coverage.
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
    """Enter what a perfect choice among `METHODS` would have gained, where something was chosen.

    Not all of it is the selection's fault: the least of several errors is small by chance, too.
    """
    of_observation = ["frame", "actor_id"]
    best, oracle = (
        _of_method(fitted, method).set_index(of_observation)["heading_error_deg"].abs() for method in ("best", "oracle")
    )
    regret = best - oracle.reindex(best.index)
    vehicle = best.index.get_level_values("actor_id").to_numpy()
    sheet.mean("fit.best.regret_deg", regret.to_numpy(), why_none, vehicle)


def _grade_bound(sheet: MetricSheet, best: pd.DataFrame, why_none: str) -> None:
    """Enter the mean absolute heading error over that of normal errors at the bound: sqrt(2 / pi) of it each."""
    bounded = best[best["heading_bound_deg"].notna()]
    error = bounded["heading_error_deg"].abs().to_numpy()
    at_bound = np.sqrt(2.0 / np.pi) * bounded["heading_bound_deg"].to_numpy()
    why = "no observation has a bound: its range noise is none or unknown, or no face shows two clean points"
    sheet.ratio("fit.best.bound_ratio", error, at_bound, why if len(best) else why_none, bounded["actor_id"].to_numpy())

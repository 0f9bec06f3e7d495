"""How well single-frame rectangles fit: the paper's tables of heading errors, and position and overlap beside them."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from scenarios.grading.geometry import QUARTER, Floats, Ints, corner, iou, matching_sign, nearest_sign, wrap
from scenarios.grading.metrics import FIT_METHODS, VIEWS
from scenarios.grading.ownership import NOBODY, Ownership
from scenarios.grading.sheet import MetricSheet
from sensor_model.truth import ScanTruth
from sim.world import Actors
from tracker.records import METHODS, Candidates

BOX = ("x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m")
TRUE_BOX = ("true_x_ego_m", "true_y_ego_m", "true_yaw_ego_rad", "true_length_m", "true_width_m")


def rows(
    actors: Actors, boxes_ego: Floats, truth: ScanTruth, ownership: Ownership, candidates: Candidates
) -> dict[str, npt.NDArray[Any]]:
    """Return the fit observations of one frame: a row per graded vehicle that has a segment, and method."""
    owner, segment = _largest_segments(ownership)
    box = np.dstack([candidates.center_ego[segment], candidates.heading[segment], candidates.size[segment]]).reshape(
        -1, len(BOX)
    )
    method = np.tile(np.arange(len(METHODS)), len(segment))

    def each(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.repeat(values, len(METHODS))

    return {
        "segment": each(segment),
        "actor_id": each(actors.id[owner]),
        "view": each(truth.view[owner]),
        "range_m": each(np.hypot(boxes_ego[owner, 0], boxes_ego[owner, 1])),
        "points": each(ownership.size[segment]),
        "method": method,
        "cost": candidates.cost[segment].ravel(),
        "best": method == each(candidates.best[segment]),
        **dict(zip(BOX, box.T, strict=True)),
        **dict(zip(TRUE_BOX, np.repeat(boxes_ego[owner], len(METHODS), axis=0).T, strict=True)),
    }


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
    least = np.where(fitted, np.abs(error), np.inf).reshape(-1, len(METHODS)).argmin(axis=1)
    oracle = fitted & (fits["method"].cat.codes.to_numpy() == np.repeat(least, len(METHODS)))
    return fits.assign(
        heading_error_deg=error, position_error_m=np.hypot(gap[:, 0], gap[:, 1]), iou=iou(box, true), oracle=oracle
    )


def grade(sheet: MetricSheet, fits: pd.DataFrame, why_none: str) -> None:
    """Enter every `fit` metric; a method that fitted no rectangle to an observation is not charged for it."""
    fitted = fits[np.isfinite(fits["heading_error_deg"])]
    for scope in (None, *VIEWS.values()):
        seen = fitted if scope is None else fitted[fitted["view"] == scope]
        why = why_none if scope is None or not len(fitted) else f"no observation is a {scope} view"
        for method in FIT_METHODS:
            prefix = f"fit.{method}" if scope is None else f"fit.{scope}.{method}"
            _grade_method(sheet, prefix, _of_method(seen, method), why)
    best, oracle = (_of_method(fitted, method)["heading_error_deg"].abs() for method in ("best", "oracle"))
    regret = float(best.mean() - oracle.mean()) if len(best) else None
    sheet.write("fit.best.regret_deg", regret, len(best), why_none)


def _of_method(fits: pd.DataFrame, method: str) -> pd.DataFrame:
    return fits[fits[method]] if method in ("best", "oracle") else fits[fits["method"] == method]


def _grade_method(sheet: MetricSheet, prefix: str, fits: pd.DataFrame, why_none: str) -> None:
    error = fits["heading_error_deg"].to_numpy()
    sheet.mean(f"{prefix}.heading_mean_deg", error, why_none)
    sheet.std(f"{prefix}.heading_std_deg", error, why_none)
    sheet.mean(f"{prefix}.heading_abs_mean_deg", np.abs(error), why_none)
    sheet.std(f"{prefix}.heading_abs_std_deg", np.abs(error), why_none)
    for limit in range(1, 6):
        sheet.mean(f"{prefix}.within_{limit}deg", np.abs(error) <= limit, why_none)
    sheet.mean(f"{prefix}.position_abs_mean_m", fits["position_error_m"].to_numpy(), why_none)
    sheet.mean(f"{prefix}.iou_mean", fits["iou"].to_numpy(), why_none)

"""Metrics of the rectangles fitted to single frames, overall, by view, by range and by number of points."""

from collections.abc import Iterator
from statistics import NormalDist

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Ints
from luxloop.scenarios.grading.metric_names import CORNER_FIGURES, COVERAGES, FIT_METHODS, POINT_BANDS
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.track_metric_names import RANGE_BANDS, VIEWS
from luxloop.tracker.records import BASELINES

NO_BASELINES = "the tracker fitted no baselines: [tracker.baselines] enabled = true"
NO_BOX = "no fitted rectangle became a box of vehicle size"
NO_BOUND = "no observation has a bound: range noise or rig are unknown, or no points hold information on the heading"
NO_EXTENT = "the visible extents are unknown: the grader has no rig"
USED = (
    *("frame", "actor_id", "method", "view", "range_m", "points", "best", "oracle"),
    *("heading_error_deg", "heading_bound_deg", "box_heading_error_deg", "box_heading_std_deg"),
    *("position_error_m", "iou", *(f"{figure}_error_m" for figure in CORNER_FIGURES)),
)
"""Columns that the metrics need: rows are selected a hundred times, faster from fewer columns."""
ROUNDED_DEG = 0.5
"""Errors below this are zero in whole degrees [deg]."""


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
    fitted = with_regret(fits.loc[np.isfinite(fits["heading_error_deg"]), [*USED]]).copy()  # joins columns of a type
    sheet.rate("fit.best.coverage", int(fitted["best"].sum()), observations, why_none)
    for scope in (None, *VIEWS.values()):
        seen = fitted if scope is None else fitted[fitted["view"] == scope]
        why = why_none if scope is None or not len(fitted) else f"no observation is a {scope} view"
        prefix = "fit" if scope is None else f"fit.{scope}"
        for method in FIT_METHODS:
            _grade_method(sheet, f"{prefix}.{method}", of_method(seen, method), _why(seen, method, why))
        _grade_best(sheet, f"{prefix}.best", of_method(seen, "best"), why)
    for band, seen in in_bands(fitted):
        why = why_none if not len(fitted) else "no observation is in this band"
        for method in FIT_METHODS:
            own = of_method(seen, method)
            error, name = own["heading_error_deg"].abs().to_numpy(), f"fit.{method}.heading_abs_mean_deg.{band}"
            sheet.mean(name, error, _why(seen, method, why), _vehicle(own))
        _mean(sheet, f"fit.best.regret_deg.{band}", of_method(seen, "best"), "regret_deg", why)


def with_regret(fitted: pd.DataFrame) -> pd.DataFrame:
    """Add `regret_deg`: the gain of a perfect selection among `METHODS`, NaN except for selected rectangles.

    The regret overstates the fault of the selection, because the least of several errors is partly small by chance.
    """
    key = ["frame", "actor_id"]
    oracle = fitted[fitted["oracle"]].set_index(key)["heading_error_deg"].abs()
    least = oracle.reindex(pd.MultiIndex.from_frame(fitted[key])).to_numpy()
    regret = fitted["heading_error_deg"].abs().to_numpy() - least
    return fitted.assign(regret_deg=np.where(fitted["best"], regret, np.nan))


def of_method(fits: pd.DataFrame, method: str) -> pd.DataFrame:
    """Return the rows of a method, of the selection (`best`) or of the least errors (`oracle`)."""
    return fits[fits[method]] if method in ("best", "oracle") else fits[fits["method"] == method]


def in_bands(fits: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the end of the metric's name and the rows of each band of range and of points."""
    for kind, column, bands in (("by_range", "range_m", RANGE_BANDS), ("by_points", "points", POINT_BANDS)):
        for name, (low, high) in bands.items():
            yield f"{kind}.{name}", fits[(fits[column] >= low) & (fits[column] < high)]


def _why(seen: pd.DataFrame, method: str, why: str) -> str:
    return NO_BASELINES if len(seen) and method in BASELINES else why


def _mean(sheet: MetricSheet, name: str, fits: pd.DataFrame, column: str, why_none: str) -> None:
    """Enter the mean of a column over the rows that have a value."""
    known = fits[fits[column].notna()]
    sheet.mean(name, known[column].to_numpy(), why_none, known["actor_id"].to_numpy())


def _grade_method(sheet: MetricSheet, prefix: str, fits: pd.DataFrame, why_none: str) -> None:
    error, vehicle = fits["heading_error_deg"].to_numpy(), _vehicle(fits)
    sheet.mean(f"{prefix}.heading_mean_deg", error, why_none, vehicle)
    sheet.std(f"{prefix}.heading_std_deg", error, why_none, vehicle)
    sheet.mean(f"{prefix}.heading_abs_mean_deg", np.abs(error), why_none, vehicle)
    sheet.std(f"{prefix}.heading_abs_std_deg", np.abs(error), why_none, vehicle)
    sheet.mean(f"{prefix}.rounded_to_0deg", np.abs(error) < ROUNDED_DEG, why_none, vehicle)
    for limit in range(1, 6):
        sheet.mean(f"{prefix}.within_{limit}deg", np.abs(error) <= limit, why_none, vehicle)
    sheet.mean(f"{prefix}.position_abs_mean_m", fits["position_error_m"].to_numpy(), why_none, vehicle)
    sheet.mean(f"{prefix}.iou_mean", fits["iou"].to_numpy(), why_none, vehicle)


def _vehicle(fits: pd.DataFrame) -> Ints:
    return np.asarray(fits["actor_id"].to_numpy())


def _grade_best(sheet: MetricSheet, prefix: str, best: pd.DataFrame, why_none: str) -> None:
    """Enter the metrics of the selection alone: regret, corner and extents, coverage of the covariance, and bound."""
    _mean(sheet, f"{prefix}.regret_deg", best, "regret_deg", why_none)
    for figure in CORNER_FIGURES:
        known = best[best[f"{figure}_error_m"].notna()]
        error, why = known[f"{figure}_error_m"].to_numpy(), NO_EXTENT if len(best) else why_none
        sheet.mean(f"{prefix}.{figure}_mean_m", error, why, _vehicle(known))
        sheet.mean(f"{prefix}.{figure}_abs_mean_m", np.abs(error), why, _vehicle(known))
    _grade_coverage(sheet, prefix, best, why_none)
    _grade_bound(sheet, prefix, best, why_none)


def _grade_coverage(sheet: MetricSheet, prefix: str, best: pd.DataFrame, why_none: str) -> None:
    """Enter the shares of true headings inside the central intervals of the boxes' heading variance."""
    boxed = best[best["box_heading_std_deg"].notna()]
    error = boxed["box_heading_error_deg"].abs().to_numpy() / boxed["box_heading_std_deg"].to_numpy()
    for percent in COVERAGES:
        quantile = NormalDist().inv_cdf(0.5 + 0.005 * percent)
        sheet.mean(
            f"{prefix}.coverage_{percent}", error <= quantile, NO_BOX if len(best) else why_none, _vehicle(boxed)
        )


def _grade_bound(sheet: MetricSheet, prefix: str, best: pd.DataFrame, why_none: str) -> None:
    """Enter the mean absolute heading error over that of normal errors at the bound, sqrt(2 / pi) times the bound."""
    bounded = best[best["heading_bound_deg"].notna()]
    error = bounded["heading_error_deg"].abs().to_numpy()
    at_bound = np.sqrt(2.0 / np.pi) * bounded["heading_bound_deg"].to_numpy()
    sheet.ratio(f"{prefix}.bound_ratio", error, at_bound, NO_BOUND if len(best) else why_none, _vehicle(bounded))

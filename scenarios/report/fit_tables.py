"""Tables of the fits that the paper does not have: by range and points, selection and covariance, corner and size."""

from luxloop.scenarios.document.table import Table
from luxloop.scenarios.document.words import Style
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import (
    CORNER_FIGURES,
    COVERAGES,
    FIT_METHODS,
    POINT_BANDS,
    RANGE_BANDS,
    VIEWS,
)
from luxloop.scenarios.report.cells import interval_of, percent_of, table_of, value_of
from luxloop.scenarios.result import Result
from luxloop.tracker.records import BASELINES

SCOPES = {"all": "", **{view.replace("_", "-"): view for view in VIEWS.values()}}
"""Views by their names in the tables; all without one."""
BANDS = {
    **{f"{band} m": {"range": band} for band in RANGE_BANDS},
    **{f"{band} points": {"points": band} for band in POINT_BANDS},
}
"""Filters by their names in the tables."""


def of_method(figure: str, method: str, **filters: str) -> str:
    """Return the name of a figure of a method's rectangles."""
    return filtered(f"fit.{figure}", method="" if method == FIT_METHODS[0] else method, **filters)


def methods_of(result: Result) -> list[str]:
    """Return the methods with fits: all except disabled baselines."""
    return [m for m in FIT_METHODS if m not in BASELINES or result.metrics[of_method("heading_mean_deg", m)].n]


def emphasis(method: str) -> Style:
    """Return the style of a method's row."""
    return "bold" if method == "best" else "dim" if method == "oracle" else ""


def heading_by_band(result: Result) -> Table:
    """Return mean absolute heading errors by range and by number of points."""
    title = "Mean absolute fit heading error by range and by points of the segment [deg]"
    table = table_of(title, "method", *(name.replace("points", "pts") for name in BANDS))
    for method in methods_of(result):
        metrics = [result.metrics[of_method("heading_abs_mean_deg", method, **band)] for band in BANDS.values()]
        table.add_row(method, *map(value_of, metrics), style=emphasis(method))
    counts = [str(result.metrics[filtered("fit.heading_abs_mean_deg", **band)].n) for band in BANDS.values()]
    table.add_row("n", *counts, style="dim")
    return table


def selection(result: Result) -> Table:
    """Return the regret of the selection, the coverage of the headings' intervals, and the ratio to the bound."""
    columns = (*(f"in {percent} %" for percent in COVERAGES), "over bound", "n")
    table = table_of(
        "Selected fits: regret of the fit heading [deg], true headings inside its intervals",
        "",
        "regret",
        "95 %",
        *columns,
    )
    for name, scope in SCOPES.items():
        regret, ratio, *coverage = (
            result.metrics[filtered(f"fit.{figure}", view=scope)]
            for figure in ("regret_deg", "bound_ratio", *(f"coverage_{percent}" for percent in COVERAGES))
        )
        cells = [value_of(regret), interval_of(regret), *map(percent_of, coverage), value_of(ratio), str(regret.n)]
        table.add_row(name, *cells)
    for name, band in BANDS.items():
        regret = result.metrics[filtered("fit.regret_deg", **band)]
        blank = [""] * (len(COVERAGES) + 1)
        table.add_row(name, value_of(regret), interval_of(regret), *blank, str(regret.n))
    return table


def corner_and_extents(result: Result) -> Table:
    """Return means and mean absolute values of the errors of the nearest corner and of the visible extents."""
    heads = [head for name in CORNER_FIGURES for head in (name.replace("_", "\n"), "\n|e|")]
    table = table_of("Selected fits: nearest corner (+ is outside) and visible extents, means [m]", "", *heads, "n")
    for name, scope in SCOPES.items():
        metrics = [
            result.metrics[filtered(f"fit.{figure}_{kind}_m", view=scope)]
            for figure in CORNER_FIGURES
            for kind in ("mean", "abs_mean")
        ]
        table.add_row(name, *map(value_of, metrics), str(metrics[0].n))
    return table

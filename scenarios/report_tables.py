"""The tables of a report: the paper's three with simulated truth, then those on every other stage."""

from itertools import product

from rich import box
from rich.table import Table
from rich.text import Text

from scenarios import paper
from scenarios.expect import Check
from scenarios.grading.metrics import (
    CAUSES,
    DRIVERS,
    ESTIMATES,
    FIT_METHODS,
    REGISTRY,
    SAFETY,
    TARGETS,
    TIMED_STAGES,
    VIEWS,
)
from scenarios.result import Metric, Result

NONE = "n/a"
"""Stands where a metric does not apply."""


def heading_error(result: Result) -> Table:
    """The paper's table II."""
    columns = ("mean", "STD", "mean |e|", "STD |e|", "n")
    table = _table("Heading error by method, modulo 90 degrees [deg]", "method", *columns)
    for column in ("paper: mean |e|", "STD |e|"):
        table.add_column(column, justify="right", style="dim", no_wrap=True)
    for method in FIT_METHODS:
        names = ("heading_mean_deg", "heading_std_deg", "heading_abs_mean_deg", "heading_abs_std_deg")
        metrics = [result.metrics[f"fit.{method}.{name}"] for name in names]
        published = [f"{value:.3f}" for value in paper.HEADING_ABS_DEG.get(method, ())]
        table.add_row(method, *map(_value, metrics), str(metrics[0].n), *published, style=_emphasis(method))
    return table


def heading_distribution(result: Result) -> Table:
    """The paper's table III."""
    table = _table("Share of heading errors of at most", "method", *(f"{limit} deg" for limit in range(1, 6)))
    for method in FIT_METHODS:
        shares = [_percent(result.metrics[f"fit.{method}.within_{limit}deg"]) for limit in range(1, 6)]
        table.add_row(method, *shares, style=_emphasis(method))
    for method, published in paper.WITHIN.items():
        table.add_row(f"paper: {method}", *(f"{share:.1%}" for share in published), style="dim")
    return table


def heading_by_view(result: Result) -> Table:
    """How the error depends on what is seen of a vehicle."""
    counts = {view: result.metrics[f"fit.{view}.best.heading_abs_mean_deg"].n for view in VIEWS.values()}
    columns = (f"{view.replace('_', '-')}, n = {count}" for view, count in counts.items())
    table = _table("Mean absolute heading error by view [deg]", "method", *columns)
    for method in FIT_METHODS:
        metrics = [result.metrics[f"fit.{view}.{method}.heading_abs_mean_deg"] for view in counts]
        table.add_row(method, *map(_value, metrics), style=_emphasis(method))
    return table


def position_error(result: Result) -> Table:
    """The paper's table IV."""
    columns = ("targets", "x mean", "x STD", "y mean", "y STD", "n")
    table = _table("Absolute error of the tracked corner, on the ego's axes [m]", "model", *columns)
    for target, estimate in product(TARGETS, ESTIMATES):
        metrics = [
            result.metrics[f"mma.{estimate}.{target}.{axis}_abs_{statistic}_m"]
            for axis, statistic in product("xy", ("mean", "std"))
        ]
        style = "bold" if estimate == "mma" else ""
        table.add_row(estimate, target.split("_")[0], *map(_value, metrics), str(metrics[0].n), style=style)
    for (model, targets), published in paper.POSITION_ABS_M.items():
        table.add_row(f"paper: {model}", targets, *(f"{value:.3f}" for value in published), style="dim")
    return table


def outliers(result: Result) -> Table:
    """Which noise the tracker removes before it fits."""
    table = _table("Outlier removal by cause of the outlier", "cause", "precision", "recall", "points")
    for cause in CAUSES.values():
        precision, recall = (result.metrics[f"outliers.{cause}.{name}"] for name in ("precision", "recall"))
        table.add_row(cause.replace("_", " "), _value(precision), _value(recall), str(recall.n))
    return table


def one_by_one(title: str, result: Result, beginnings: tuple[str, ...]) -> Table:
    """A line for each metric whose name begins so, with its meaning."""
    table = _table(title, "metric", "value", "n")
    table.add_column("", style="dim")
    for name, metric in result.metrics.items():
        if name.startswith(beginnings):
            table.add_row(name, _value(metric), str(metric.n), metric.reason or REGISTRY[name].meaning)
    return table


def control(result: Result) -> Table:
    """How safely the controlled ego drove by the tracks, and by the truth beside that."""
    table = _table("Controlled ego, by the truth of its drives", "", *(f"by the {driver}" for driver in DRIVERS))
    for name, (unit, meaning) in SAFETY.items():
        metrics = [result.metrics[f"control.{prefix}{name}"] for prefix in DRIVERS.values()]
        table.add_row(Text(f"{meaning} [{unit}]"), *map(_value, metrics))
    return table


def speed(result: Result) -> Table:
    """Time per frame and stage, and how the whole loop compares with real time."""
    table = _table("Time per frame [ms]", "stage", "median", "99 %")
    for stage in TIMED_STAGES:
        quantiles = [result.metrics[f"perf.{stage}_ms_{quantile}"] for quantile in ("p50", "p99")]
        table.add_row(stage, *map(_value, quantiles), end_section=stage == TIMED_STAGES[-1])
    factor = result.metrics["perf.realtime_factor"].value
    table.add_row("whole loop", f"{factor:.1f} x real time", "without recording")
    return table


def expectations(checks: list[Check]) -> Table:
    """Limits of the scenario beside what came out."""
    table = _table("Expectations", "metric", "limit", "value")
    table.add_column("")
    for check in checks:
        mark = Text("passed", style="green") if check.passed else Text("FAILED", style="bold red")
        mark.append(f" {check.metric.reason}", style="not bold dim")
        table.add_row(check.name, str(check.limit), _value(check.metric), mark)
    return table


def _table(title: str, first_column: str, *number_columns: str) -> Table:
    # A title goes in as Text: in plain strings rich would take [deg] for a style.
    table = Table(
        title=Text(title, style="bold"), title_justify="left", box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    table.add_column(first_column, no_wrap=True)
    for column in number_columns:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def _emphasis(method: str) -> str:
    return {"best": "bold", "oracle": "dim"}.get(method, "")


def _value(metric: Metric) -> str:
    if metric.value is None:
        return NONE
    return f"{metric.value:.0f}" if metric.unit == "count" else f"{metric.value:.3f}"


def _percent(metric: Metric) -> str:
    return NONE if metric.value is None else f"{metric.value:.1%}"

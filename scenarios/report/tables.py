"""Tables of a report that the paper does not have: stages, controlled ego, and speed."""

from collections.abc import Iterable, Mapping
from typing import Any

from luxloop.scenarios.document.document import Paragraph
from luxloop.scenarios.document.table import Table
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.metrics.definitions import (
    CAUSES,
    DRIVERS,
    HORIZONS,
    SAFETY,
    TIMED_STAGES,
    estimates,
    find_metric,
)
from luxloop.scenarios.report.cells import interval_of, percent_of, table_of, value_of
from luxloop.scenarios.result import Metric, Result
from luxloop.tracker.records import MODELS


def modes(result: Result) -> Table:
    """Return the confusion table of the selected model by true mode."""
    models = result.metrics.run.models
    table = table_of("Selected model by true mode", "true mode", *models, "n")
    for mode in MODELS:
        rates = [result.metrics[f"mma.selected{{mode={mode},model={model}}}"] for model in models]
        table.add_row(mode, *map(percent_of, rates), str(rates[0].n))
    return table


def predictions(result: Result) -> Table:
    """Return the errors of predicted positions, overall and around changes of the true mode."""
    title = "Mean distance of the tracked corner from its prediction [m]; changes: within 1 s of a change of mode"
    labels = [f"{seconds:g} s{where}" for where in ("", ", changes") for seconds in HORIZONS.values()]
    table = table_of(title, "model", *labels, "n")
    for estimate in estimates(result.metrics.run.models):
        found = [
            result.metrics[filtered(f"mma.prediction_{label}_abs_mean_m", model=estimate, when=when)]
            for when in ("any", "changing")
            for label in HORIZONS
        ]
        table.add_row(estimate, *map(value_of, found), str(found[0].n), style="bold" if estimate == "mma" else "")
    return table


def consistency(result: Result) -> Table:
    """Return a table of NEES and NIS of the filters."""
    title = "Consistency of the filters, each while it is the true mode: share in the chi-square band, mean (2)"
    table = table_of(title, "model", "NEES in band", "NEES mean", "NIS in band", "NIS mean", "n")
    for model in result.metrics.run.models:
        nees, nees_mean, nis, nis_mean = (
            result.metrics[f"mma.{name}_{what}{{model={model}}}"]
            for name in ("nees", "nis")
            for what in ("in_band", "mean")
        )
        cells = [percent_of(nees), value_of(nees_mean), percent_of(nis), value_of(nis_mean), str(nees.n)]
        table.add_row(model, *cells)
    nees, mean = result.metrics["mma.nees_in_band"], result.metrics["mma.nees_mean"]
    table.add_row("mma, always", percent_of(nees), value_of(mean), "", "", str(nees.n), style="bold")
    return table


def outliers(result: Result) -> Table:
    """Return precision and recall of outlier removal by cause."""
    table = table_of("Outlier removal by cause of the outlier", "cause", "precision", "recall", "points")
    for cause in CAUSES.values():
        precision, recall = (result.metrics[f"outliers.{name}{{cause={cause}}}"] for name in ("precision", "recall"))
        table.add_row(cause.replace("_", " "), value_of(precision), value_of(recall), str(recall.n))
    return table


def metric_list(title: str, result: Result, prefixes: tuple[str, ...]) -> Table:
    """Return a table with a row for each metric with one of the prefixes."""
    return metric_rows(title, result, [name for name in result.metrics if name.startswith(prefixes)])


def metric_rows(title: str, result: Result, names: Iterable[str]) -> Table:
    """Return a table with a row for each metric of a run: its value, 95 % interval and meaning."""
    return figure_rows(title, result.metrics, names)


def figure_rows(title: str, metrics: Mapping[str, Metric], names: Iterable[str]) -> Table:
    """Return a table with a row for each of these metrics: its value, 95 % interval and meaning."""
    table = table_of(title, "metric", "value", "95 %", "n")
    table.add_column("", style="dim")
    for name in names:
        metric = metrics[name]
        meaning = metric.reason or find_metric(name).meaning
        table.add_row(name, value_of(metric), interval_of(metric), str(metric.n), meaning)
    return table


def control(result: Result) -> Table:
    """Return the safety metrics of the controlled ego, driven by the tracks and by the truth."""
    table = table_of("Controlled ego, by the truth of its drives", "", *(f"by the {driver}" for driver in DRIVERS))
    for name, (unit, meaning, *_) in SAFETY.items():
        metrics = [result.metrics[f"control.{prefix}{name}"] for prefix in DRIVERS.values()]
        table.add_row(f"{meaning} [{unit}]", *map(value_of, metrics))
    return table


def speed(result: Result) -> Table:
    """Return the time per frame and stage, and the real-time factor of the whole loop."""
    table = table_of("Time per frame [ms]", "stage", "median", "99 %")
    for stage in TIMED_STAGES:
        quantiles = [result.metrics[f"perf.{stage}_ms_{quantile}"] for quantile in ("p50", "p99")]
        table.add_row(stage, *map(value_of, quantiles), end_section=stage == TIMED_STAGES[-1])
    factor = result.metrics["perf.realtime_factor"].value
    if factor is not None:
        table.add_row("whole loop", f"{factor:.1f} x real time", "without recording")
    return table


def grading_limits(limits: Mapping[str, Any]) -> Paragraph:
    """Return the limits of grading, which the metrics depend on; those that are no numbers are left out."""
    numbers = {name: value for name, value in limits.items() if isinstance(value, int | float)}
    return Paragraph("Graded with " + ", ".join(f"{name} = {value:g}" for name, value in numbers.items()), "dim")

"""The tables of a report on the stages behind the paper's tables, on speed, and on what was expected."""

from rich.table import Table
from rich.text import Text

from scenarios.files.expect import Check, ExpectationOutcome
from scenarios.grading.metric_names import CAUSES, DRIVERS, REGISTRY, SAFETY, TIMED_STAGES
from scenarios.report.cells import percent_of, table_of, value_of
from scenarios.result import Result
from tracker.records import MODELS


def modes(result: Result) -> Table:
    """Which model is selected, by how the vehicle truly moves."""
    table = table_of("Selected model by true mode", "true mode", *MODELS, "n")
    for mode in MODELS:
        rates = [result.metrics[f"mma.confusion.{mode}.{model}"] for model in MODELS]
        table.add_row(mode, *map(percent_of, rates), str(rates[0].n))
    return table


def consistency(result: Result) -> Table:
    """Whether the filters know how well they know."""
    title = "Consistency of the filters, each alone while it is the true mode: share in the chi-square band, mean (2)"
    table = table_of(title, "model", "NEES in band", "NEES mean", "NIS in band", "NIS mean", "n")
    for model in MODELS:
        nees, nees_mean, nis, nis_mean = (
            result.metrics[f"mma.{model}.{name}_{what}"] for name in ("nees", "nis") for what in ("in_band", "mean")
        )
        cells = [percent_of(nees), value_of(nees_mean), percent_of(nis), value_of(nis_mean), str(nees.n)]
        table.add_row(model, *cells)
    nees, mean = result.metrics["mma.nees_in_band"], result.metrics["mma.nees_mean"]
    table.add_row("mma, always", percent_of(nees), value_of(mean), "", "", str(nees.n), style="bold")
    return table


def outliers(result: Result) -> Table:
    """Which noise the tracker removes before it fits."""
    table = table_of("Outlier removal by cause of the outlier", "cause", "precision", "recall", "points")
    for cause in CAUSES.values():
        precision, recall = (result.metrics[f"outliers.{cause}.{name}"] for name in ("precision", "recall"))
        table.add_row(cause.replace("_", " "), value_of(precision), value_of(recall), str(recall.n))
    return table


def one_by_one(title: str, result: Result, beginnings: tuple[str, ...]) -> Table:
    """A line for each metric whose name begins so, with its meaning."""
    table = table_of(title, "metric", "value", "n")
    table.add_column("", style="dim")
    for name, metric in result.metrics.items():
        if name.startswith(beginnings):
            table.add_row(name, value_of(metric), str(metric.n), metric.reason or REGISTRY[name].meaning)
    return table


def control(result: Result) -> Table:
    """How safely the controlled ego drove by the tracks, and by the truth beside that."""
    table = table_of("Controlled ego, by the truth of its drives", "", *(f"by the {driver}" for driver in DRIVERS))
    for name, (unit, meaning) in SAFETY.items():
        metrics = [result.metrics[f"control.{prefix}{name}"] for prefix in DRIVERS.values()]
        table.add_row(Text(f"{meaning} [{unit}]"), *map(value_of, metrics))
    return table


def speed(result: Result) -> Table:
    """Time per frame and stage, and how the whole loop compares with real time."""
    table = table_of("Time per frame [ms]", "stage", "median", "99 %")
    for stage in TIMED_STAGES:
        quantiles = [result.metrics[f"perf.{stage}_ms_{quantile}"] for quantile in ("p50", "p99")]
        table.add_row(stage, *map(value_of, quantiles), end_section=stage == TIMED_STAGES[-1])
    factor = result.metrics["perf.realtime_factor"].value
    if factor is not None:
        table.add_row("whole loop", f"{factor:.1f} x real time", "without recording")
    return table


STYLES: dict[ExpectationOutcome, str] = {
    "passed": "green",
    "failed": "bold red",
    "known failure": "yellow",
    "unexpected pass": "bold cyan",
}


def expectations(checks: list[Check]) -> Table:
    """Limits of the scenario beside what came out, and the need behind each, or why it is known to fail."""
    table = table_of("Expectations", "metric", "limit", "value")
    table.add_column("")
    table.add_column("", style="dim")
    for check in checks:
        mark = Text(check.outcome.upper() if check.outcome == "failed" else check.outcome, style=STYLES[check.outcome])
        why = check.metric.reason or check.limit.known_failure or check.limit.need
        table.add_row(check.name, str(check.limit), value_of(check.metric), mark, why)
    return table

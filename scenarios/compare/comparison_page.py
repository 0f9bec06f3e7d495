"""Comparison as one HTML page."""

import math
import shlex
from collections.abc import Sequence

from luxloop.scenarios.compare.change_figure import change_figure
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from luxloop.scenarios.compare.comparison import Comparison, MetricChange
from luxloop.scenarios.compare.comparison_summary import (
    INTERVALS,
    compared_runs,
    expected_value,
    false_positives,
    interval,
    number,
    sentence,
    statements,
)
from luxloop.scenarios.compare.run_pair import Pair
from luxloop.scenarios.report.cells import NONE
from luxloop.scenarios.report.html.page_tables import Cell, PageTable, Row
from luxloop.scenarios.report.html.pages import render

BADGES = {
    "worse": "failed", "lost": "failed", "newly failed": "failed", "better": "passed", "mended": "passed",
    "same": "passed", "unclear": "incomplete", "cannot tell": "incomplete", "now known to fail": "known-failure",
}  # fmt: skip
"""Style of each verdict."""
KEY_METRICS = {
    "track.hota": "HOTA", "track.missed_share": "missed", "track.false_share": "false",
    "track.id_switch_rate": "id switches", "fit.heading_abs_mean_deg": "fit heading [deg]",
}  # fmt: skip
"""Metrics of single runs, with short names."""


def comparison_page(comparison: Comparison, base: str, head: str) -> str:
    """Return the page of a comparison; `base` and `head` are the names of the two sides."""
    return render(
        "comparison.html.j2",
        comparison=comparison,
        sides={"BASE": base, "HEAD": head},
        badges=BADGES,
        sentence=sentence(comparison),
        statements=statements(comparison),
        figure=change_figure(comparison),
        metrics=[change for change in comparison.changes if change.verdict != "not measured"],
        cells=metric_cells,
        absent=[change.metric.name for change in comparison.changes if change.verdict == "not measured"],
        explanations=[INTERVALS, false_positives(comparison) + "."],
        number=number,
        expected_value=expected_value,
        runs=run_table(comparison.pairs.compared),
        notes=compared_runs(comparison),
        command=shlex.join(["luxloop", "compare", base, head, "--loss", f"{100.0 * comparison.loss:g}"]),
    )


def metric_cells(change: MetricChange) -> list[str]:
    """Return the numbers of a metric: BASE, HEAD, change and interval, with the unit of the values."""
    numbers = change.numbers
    return [
        number(numbers.base),
        number(numbers.head),
        number(numbers.difference, sign="+"),
        interval(change),
        "" if change.metric.unit == "1" else change.metric.unit,
    ]


def run_table(pairs: Sequence[Pair]) -> PageTable:
    """Return BASE's and HEAD's key metrics of each pair of runs, those with the largest loss of HOTA first."""
    metrics = [metric for metric in COMPARED_METRICS if metric.name in KEY_METRICS]
    rows = [_run(pair, metrics) for pair in pairs]
    rows.sort(key=lambda row: -row[0])
    names = ["run", "tracks", "vehicles", *(KEY_METRICS[metric.name] for metric in metrics)]
    head = [Cell(name, column > 1) for column, name in enumerate(names)]
    return PageTable("Each pair of runs, BASE to HEAD", head, [row for _, row in rows])


def _run(pair: Pair, metrics: list[ComparedMetric]) -> tuple[float, Row]:
    """Return the loss of the first metric, and the row of a pair."""
    base, head = (sums.sum(axis=0, keepdims=True) for sums in pair.units())
    values = [(float(metric.value(base)[0]), float(metric.value(head)[0])) for metric in metrics]
    texts = [_short(b) if pair.same else f"{_short(b)} to {_short(h)}" for b, h in values]
    state = "identical" if pair.identical else "same" if pair.same else "differ" if pair.same_truth else "other traffic"
    cells = [str(pair.key), state, str(len(pair.base.vehicles.vehicle) - 1), *texts]
    loss = metrics[0].loss(values[0][1] - values[0][0])
    row = Row([Cell(text, column > 1) for column, text in enumerate(cells)], "dim" if pair.same else "")
    return (0.0 if math.isnan(loss) else loss), row


def _short(value: float) -> str:
    """Format a metric with three decimals, so that the table fits the page."""
    return NONE if math.isnan(value) else f"{value:.3f}"

"""Comparison as text: compared runs, metrics, expectations, and the verdict at the end; short as HTML."""

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from luxloop.scenarios.compare.comparison import Comparison, MetricChange
from luxloop.scenarios.compare.comparison_summary import (
    compared_runs,
    expected_value,
    false_positives,
    interval,
    number,
)
from luxloop.scenarios.compare.run_pairs import listed
from luxloop.scenarios.compare.single_scenarios import ScenarioLoss
from luxloop.scenarios.report.cells import table_of
from luxloop.scenarios.report.notebook import html_table

COLORS = {"worse": "red", "lost": "red", "better": "green", "unclear": "yellow", "cannot tell": "yellow"}
"""Colours of verdicts that need attention, the most important first."""
METRIC_COLUMNS = ("metric", "BASE", "HEAD", "change", "95 % interval")
FATES = {"newly failed": "red", "mended": "green"}


def report(comparison: Comparison) -> Group:
    """Return the printed report of a comparison."""
    sections: list[RenderableType] = [
        Text("\n".join(compared_runs(comparison))),
        _metrics(comparison.changes),
        *([_scenarios(comparison.scenario_losses)] if comparison.scenario_losses else []),
        *([_expectations(comparison)] if comparison.expectation_changes else []),
        _conclusion(comparison),
    ]
    return Group(*(Padding(section, (0, 0, 1, 0), expand=False) for section in sections))


def html(comparison: Comparison) -> str:
    """Return verdict and metrics as HTML, for notebooks."""
    measured = [change for change in comparison.changes if change.verdict != "not measured"]
    rows = [(*_metric(change), change.verdict) for change in measured]
    title = "; ".join(compared_runs(comparison))
    return html_table(title, _conclusion(comparison).plain, (*METRIC_COLUMNS, "verdict"), rows)


def _metrics(changes: list[MetricChange]) -> Table:
    """Return a table with a row per metric; changed ones are followed by the runs with the largest contributions."""
    table = table_of("Metrics", *METRIC_COLUMNS)
    table.add_column("verdict", no_wrap=True)
    for change in changes:
        if change.verdict == "not measured":
            continue
        table.add_row(*_metric(change), Text(change.verdict, style=COLORS.get(change.verdict, "")))
        for key, moved in change.where.items():
            table.add_row(Text(f"  {key}", style="dim"), "", "", Text(number(moved, sign="+"), style="dim"))
    return table


def _metric(change: MetricChange) -> tuple[str, ...]:
    """Return the cells of `METRIC_COLUMNS`."""
    numbers = change.numbers
    return (
        change.metric.name,
        *(number(value) for value in (numbers.base, numbers.head)),
        number(numbers.difference, sign="+"),
        interval(change, ", "),
    )


def _scenarios(losses: list[ScenarioLoss]) -> Table:
    """Return a table with the clearest loss of each scenario that has one."""
    table = table_of("Losses in single scenarios", "scenario", "metric", "BASE", "HEAD", "vehicles", "p")
    for loss in losses:
        values = (number(loss.base), number(loss.head), str(loss.units), f"{loss.p:.2g}")
        table.add_row(loss.scenario, loss.metric.name, *values)
    return table


def _expectations(comparison: Comparison) -> Table:
    """Return a table of the expectations that fail on at least one side."""
    table = table_of("Expectations", "run", "limit", "BASE", "HEAD")
    table.add_column("", no_wrap=True)
    for change in comparison.expectation_changes:
        style = FATES.get(change.fate, "")
        values = (expected_value(change.base), expected_value(change.head))
        table.add_row(str(change.key), f"{change.name} {change.head.limit}", *values, Text(change.fate, style=style))
    return table


def _conclusion(comparison: Comparison) -> Text:
    """Return the verdicts on metrics and on expectations, with their reasons."""
    verdict, early = comparison.verdict, comparison.pairs.newly_incomplete
    text = Text(verdict.upper(), style=f"bold {COLORS.get(verdict, 'green')}")
    text.append(f": {_reasons(comparison)}", style="not bold default")
    failed = sum(change.fate == "newly failed" for change in comparison.expectation_changes)
    if failed:
        text.append(f"\nNEWLY FAILED: {failed} expectations that BASE met or did not have", style="red")
    if early:
        text.append(f"\nNEWLY INCOMPLETE: {listed(early)}", style="red")
    if any(change.verdict == "unclear" for change in comparison.changes):
        more = f"a loss of {100.0 * comparison.loss:g} % cannot be excluded; run more seeds, or state a larger --loss"
        text.append(f"\nUnclear: {more}", style="dim")
    absent = [change.metric.name for change in comparison.changes if change.verdict == "not measured"]
    if absent:
        text.append(f"\nNo observations: {', '.join(absent)}", style="dim")
    text.append(f"\n{false_positives(comparison)}", style="dim")
    return text


def _reasons(comparison: Comparison) -> str:
    """List the metrics and scenarios by verdict."""
    reasons = []
    for verdict in COLORS:
        names = [change.metric.name for change in comparison.changes if change.verdict == verdict]
        names += [loss.scenario for loss in comparison.scenario_losses if verdict == "worse"]
        reasons += [f"{verdict}: {', '.join(names)}"] if names else []
    if all(change.verdict == "not measured" for change in comparison.changes):
        return "no metric has a value"
    return "; ".join(reasons) or "no metric has changed"

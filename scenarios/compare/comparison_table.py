"""Comparison as text: compared runs, metrics, expectations, and the verdict at the end."""

import math

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from scenarios.compare.comparison import LEVEL, Comparison, MetricChange
from scenarios.compare.digest import Expectation
from scenarios.compare.run_pairs import Pairs, listed
from scenarios.report.cells import NONE, table_of

COLORS = {"worse": "red", "lost": "red", "better": "green", "unclear": "yellow"}
"""Colours of verdicts that need attention, the most important first."""
FATES = {"newly failed": "red", "mended": "green"}


def report(comparison: Comparison) -> Group:
    """Return the printed report of a comparison."""
    sections: list[RenderableType] = [
        _runs(comparison.pairs),
        _metrics(comparison.changes),
        *([_expectations(comparison)] if comparison.expectation_changes else []),
        _conclusion(comparison),
    ]
    return Group(*(Padding(section, (0, 0, 1, 0), expand=False) for section in sections))


def _runs(pairs: Pairs) -> Text:
    """List the compared runs and the runs left out."""
    identical = sum(pair.identical for pair in pairs.compared)
    lines = [f"{len(pairs.compared)} pairs of runs compared, {identical} of them identical (same trace hash)"]
    lines += [f"Not compared: {key}: {why}" for key, why in pairs.incomparable.items()]
    lines += [f"Only in BASE: {listed(pairs.only_base)}"] if pairs.only_base else []
    lines += [f"Only in HEAD: {listed(pairs.only_head)}"] if pairs.only_head else []
    return Text("\n".join(lines + pairs.notes))


def _metrics(changes: list[MetricChange]) -> Table:
    """Return a table with a row per metric; changed ones are followed by the runs with the largest contributions."""
    table = table_of("Metrics", "metric", "BASE", "HEAD", "change", "95 % interval")
    table.add_column("verdict", no_wrap=True)
    for change in changes:
        if change.verdict == "not measured":
            continue
        numbers = change.numbers
        table.add_row(
            change.metric.name,
            *(_number(value) for value in (numbers.base, numbers.head)),
            _number(numbers.difference, sign="+"),
            ", ".join(_number(end, sign="+") for end in numbers.interval),
            Text(change.verdict, style=COLORS.get(change.verdict, "")),
        )
        for key, moved in change.where.items():
            table.add_row(Text(f"  {key}", style="dim"), "", "", Text(_number(moved, sign="+"), style="dim"))
    return table


def _expectations(comparison: Comparison) -> Table:
    """Return a table of the expectations that fail on at least one side."""
    table = table_of("Expectations", "run", "limit", "BASE", "HEAD")
    table.add_column("", no_wrap=True)
    for change in comparison.expectation_changes:
        style = FATES.get(change.fate, "")
        values = (_value(change.base), _value(change.head))
        table.add_row(str(change.key), f"{change.name} {change.head.limit}", *values, Text(change.fate, style=style))
    return table


def _conclusion(comparison: Comparison) -> Text:
    """Return both verdicts: changed metrics, and failures."""
    verdict, early = comparison.verdict, comparison.pairs.newly_incomplete
    text = Text(verdict.upper(), style=f"bold {COLORS.get(verdict, 'green')}")
    named = {found: [c.metric.name for c in comparison.changes if c.verdict == found] for found in COLORS}
    listed_names = [f"{found}: {', '.join(names)}" for found, names in named.items() if names]
    text.append(": " + ("; ".join(listed_names) or "no metric has changed"), style="not bold default")
    failed = sum(change.fate == "newly failed" for change in comparison.expectation_changes)
    if failed:
        text.append(f"\nNEWLY FAILED: {failed} expectations that BASE met or did not have", style="red")
    if early:
        text.append(f"\nNEWLY INCOMPLETE: {listed(early)}", style="red")
    if named["unclear"]:
        text.append("\nUnclear: a relevant change is possible; run more seeds for a decision", style="dim")
    absent = [change.metric.name for change in comparison.changes if change.verdict == "not measured"]
    if absent:
        text.append(f"\nNo observations: {', '.join(absent)}", style="dim")
    text.append(f"\nWithout any change, the probability of a better or worse is {LEVEL:.0%}", style="dim")
    return text


def _value(expectation: Expectation | None) -> str:
    return NONE if expectation is None or expectation.value is None else f"{expectation.value:.4g}"


def _number(value: float, sign: str = "") -> str:
    return NONE if math.isnan(value) else f"{value:{sign}.4f}"

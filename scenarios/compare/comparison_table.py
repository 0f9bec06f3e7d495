"""A comparison as people read it: what was compared, the metrics, the expectations, and the verdict last."""

import math

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from scenarios.compare.comparison import LEVEL, Change, Comparison
from scenarios.compare.digest import Expectation
from scenarios.compare.run_pairs import Pairs, listed
from scenarios.report.cells import NONE, table_of

COLORS = {"worse": "red", "lost": "red", "better": "green", "unclear": "yellow"}
"""Of the verdicts that want attention, those first that want most."""
FATES = {"newly failed": "red", "mended": "green"}


def report(comparison: Comparison) -> Group:
    """Everything a person wants to know of a comparison."""
    sections: list[RenderableType] = [
        _runs(comparison.pairs),
        _metrics(comparison.changes),
        *([_expectations(comparison)] if comparison.falls else []),
        _conclusion(comparison),
    ]
    return Group(*(Padding(section, (0, 0, 1, 0), expand=False) for section in sections))


def _runs(pairs: Pairs) -> Text:
    """Say what was compared, and everything that was not."""
    identical = sum(pair.identical for pair in pairs.compared)
    lines = [f"{len(pairs.compared)} pairs of runs compared, {identical} of them identical (same trace hash)"]
    lines += [f"Not compared: {key}: {why}" for key, why in pairs.unlike.items()]
    lines += [f"Only in BASE: {listed(pairs.only_base)}"] if pairs.only_base else []
    lines += [f"Only in HEAD: {listed(pairs.only_head)}"] if pairs.only_head else []
    return Text("\n".join(lines + pairs.notes))


def _metrics(changes: list[Change]) -> Table:
    """One line per metric; below those that changed, the runs that moved them."""
    table = table_of("Metrics", "metric", "BASE", "HEAD", "change", "95 % interval")
    table.add_column("verdict", no_wrap=True)
    for change in changes:
        if change.verdict == "not measured":
            continue
        numbers = change.numbers
        table.add_row(
            change.headline.name,
            *(_number(value) for value in (numbers.base, numbers.head)),
            _number(numbers.difference, sign="+"),
            ", ".join(_number(end, sign="+") for end in numbers.interval),
            Text(change.verdict, style=COLORS.get(change.verdict, "")),
        )
        for key, moved in change.where.items():
            table.add_row(Text(f"  {key}", style="dim"), "", "", Text(_number(moved, sign="+"), style="dim"))
    return table


def _expectations(comparison: Comparison) -> Table:
    """Expectations that do not hold on one of the sides."""
    table = table_of("Expectations", "run", "limit", "BASE", "HEAD")
    table.add_column("", no_wrap=True)
    for fall in comparison.falls:
        style = FATES.get(fall.fate, "")
        values = (_value(fall.base), _value(fall.head))
        table.add_row(str(fall.key), f"{fall.name} {fall.head.limit}", *values, Text(fall.fate, style=style))
    return table


def _conclusion(comparison: Comparison) -> Text:
    """Both verdicts: whether anything changed, and whether anything failed."""
    verdict, early = comparison.verdict, comparison.pairs.newly_incomplete
    text = Text(verdict.upper(), style=f"bold {COLORS.get(verdict, 'green')}")
    named = {found: [c.headline.name for c in comparison.changes if c.verdict == found] for found in COLORS}
    told = [f"{found}: {', '.join(names)}" for found, names in named.items() if names]
    text.append(": " + ("; ".join(told) or "no metric has changed"), style="not bold default")
    failed = sum(fall.fate == "newly failed" for fall in comparison.falls)
    if failed:
        text.append(f"\nNEWLY FAILED: {failed} expectations that BASE met, or did not have yet", style="red")
    if early:
        text.append(f"\nNEWLY INCOMPLETE: {listed(early)}", style="red")
    if named["unclear"]:
        text.append("\nUnclear: may have changed by more than matters; more seeds would tell", style="dim")
    absent = [change.headline.name for change in comparison.changes if change.verdict == "not measured"]
    if absent:
        text.append(f"\nNothing to measure: {', '.join(absent)}", style="dim")
    text.append(f"\nIf nothing had changed, any better or worse would have a chance of {LEVEL:.0%}", style="dim")
    return text


def _value(expectation: Expectation | None) -> str:
    return NONE if expectation is None or expectation.value is None else f"{expectation.value:.4g}"


def _number(value: float, sign: str = "") -> str:
    return NONE if math.isnan(value) else f"{value:{sign}.4f}"

"""Comparison as GitHub flavoured Markdown, short enough for the comment of a pull request."""

import re
from collections.abc import Sequence

from luxloop.scenarios.compare.comparison import Comparison
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

LISTED = 8
"""Statements under each heading; the tables hold all."""
SPECIAL = re.compile(r"([\\`*_\[\]<>#|~&$@])")
"""Characters with a meaning inside a line."""


def markdown(comparison: Comparison, base: str, head: str) -> str:
    """Return the verdict, the changes by importance, and the tables folded.

    Parameters
    ----------
    base, head
        Names of the two sides.
    """
    lines = [f"### luxloop compare: {comparison.outcome}", "", f"**{sentence(comparison)}.**", ""]
    lines += [f"BASE {code(base)}, HEAD {code(head)}.", ""]
    for heading, found in statements(comparison).items():
        lines += [f"**{heading}**", ""]
        lines += [f"- {code(one.subject)}: {plain(one.detail)}" for one in found[:LISTED]]
        lines += [f"- {len(found) - LISTED} more in the tables below"] if len(found) > LISTED else []
        lines.append("")
    lines += _folded("Metrics", [*_metrics(comparison), "", f"{INTERVALS} {false_positives(comparison)}."])
    lines += _folded("Scenarios alone", _scenarios(comparison)) if comparison.scenario_losses else []
    lines += _folded("Expectations", _expectations(comparison)) if comparison.expectation_changes else []
    lines += _folded("Runs", [f"- {plain(line)}" for line in compared_runs(comparison)])
    return "\n".join(lines)


def code(text: str) -> str:
    """Return a text as a code span on one line, also inside a table."""
    text = " ".join(text.split())
    fence = "`" * (1 + max((len(run) for run in re.findall("`+", text)), default=0))
    space = " " if "`" in text else ""
    return f"{fence}{space}{text}{space}{fence}".replace("|", "\\|")


def plain(text: str) -> str:
    """Return a text that Markdown shows as it is written, on one line."""
    return SPECIAL.sub(r"\\\1", " ".join(text.split()))


def _folded(title: str, lines: list[str]) -> list[str]:
    return [f"<details><summary>{title}</summary>", "", *lines, "", "</details>", ""]


def _table(head: tuple[str, ...], right: int, rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Return a table; columns from number `right` to the last but one are right-aligned."""
    align = ["---" if column < right or column == len(head) - 1 else "---:" for column in range(len(head))]
    return ["| " + " | ".join(row) + " |" for row in (head, tuple(align), *rows)]


def _metrics(comparison: Comparison) -> list[str]:
    rows = [
        (
            code(change.metric.name),
            number(change.numbers.base),
            number(change.numbers.head),
            number(change.numbers.difference, sign="+"),
            interval(change),
            f"**{change.verdict}**" if change.verdict in ("worse", "lost", "better") else change.verdict,
        )
        for change in comparison.changes
        if change.verdict != "not measured"
    ]
    return _table(("metric", "BASE", "HEAD", "change", "95 % interval", "verdict"), 1, rows)


def _scenarios(comparison: Comparison) -> list[str]:
    rows = [
        (
            code(loss.scenario),
            code(loss.metric.name),
            number(loss.base),
            number(loss.head),
            str(loss.units),
            f"{loss.p:.2g}",
        )
        for loss in comparison.scenario_losses
    ]
    return _table(("scenario", "metric", "BASE", "HEAD", "vehicles", "p"), 2, rows)


def _expectations(comparison: Comparison) -> list[str]:
    rows = [
        (
            code(str(change.key)),
            code(f"{change.name} {change.head.limit}"),
            expected_value(change.base),
            expected_value(change.head),
            change.fate,
        )
        for change in comparison.expectation_changes
    ]
    return _table(("run", "limit", "BASE", "HEAD", ""), 2, rows)

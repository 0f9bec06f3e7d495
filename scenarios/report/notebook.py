"""Results as HTML tables for notebooks. Every text is escaped: names and reasons come from users' files."""

from collections.abc import Iterable, Sequence
from html import escape

from luxloop.scenarios.files.expect import Check, ranked
from luxloop.scenarios.report import text
from luxloop.scenarios.report.cells import interval_of
from luxloop.scenarios.report.html.reported_run import SUITE_METRICS, with_unit
from luxloop.scenarios.result import Result

HEAD = ("metric", "value", "95 %", "limit", "outcome")


def result_table(result: Result) -> str:
    """Return the verdict, the expectations that do not hold, and the main metrics."""
    checks = result.checks
    unmet = [check for check in ranked(checks) if not check.holds]
    named = {check.name for check in unmet}
    main = [name for name in SUITE_METRICS if name in result.metrics and name not in named]
    rows = [_unmet(check) for check in unmet]
    rows += [(name, with_unit(result.metrics[name]), interval_of(result.metrics[name]), "", "") for name in main]
    title = f"{result.scenario}, seed {result.seed}, {result.frames} frames"
    return html_table(title, text.conclusion(result, checks).plain, HEAD, rows)


def html_table(title: str, verdict: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table below a title and a verdict."""
    body = "".join(_row(row, "td") for row in rows)
    table = f"<table><thead>{_row(head, 'th')}</thead><tbody>{body}</tbody></table>"
    return f"<div><p><b>{escape(title)}</b><br>{_lines(verdict)}</p>{table}</div>"


def _unmet(check: Check) -> tuple[str, ...]:
    outcome = f"{check.outcome}: {check.why}" if check.why else check.outcome
    return check.name, with_unit(check.metric), interval_of(check.metric), str(check.limit), outcome


def _row(cells: Iterable[str], tag: str) -> str:
    return f"<tr>{''.join(f'<{tag}>{_lines(cell)}</{tag}>' for cell in cells)}</tr>"


def _lines(text: str) -> str:
    return escape(text).replace("\n", "<br>")

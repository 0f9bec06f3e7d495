"""First screen of a run: verdict, limits that do not hold, main figures, worst frame and next commands.

It has at most `LINES` lines. Everything else is in the full report (`luxloop.scenarios.report.text`).
"""

import shlex
import shutil
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from luxloop.scenarios.document.document import Answer
from luxloop.scenarios.document.terminal import BOLD, CODES, CYAN, DIM, Line, Piece, print_lines
from luxloop.scenarios.files import expect
from luxloop.scenarios.files.expect import SHIPPED, Check, unmet
from luxloop.scenarios.grading.worst_frames import worst_frames
from luxloop.scenarios.metrics.main_figures import ON_FIRST_SCREEN
from luxloop.scenarios.report.cells import NONE, counted, exceeded, interval_of, unit_of, value_of
from luxloop.scenarios.report.html.reported_run import answer
from luxloop.scenarios.rerun_log.viewer import frame_to_show
from luxloop.scenarios.result import Metric, Result
from luxloop.scenarios.run import run_folder

LINES = 20
"""Most lines of the screen: it fits into any terminal."""
NARROWEST = 60
"""Fewest columns that the lines are made for."""
BLANK = 2
"""Blank lines that many limits leave."""
CAUSE_LINES, WORST_LINES = 3, 2
"""Most lines of the cause of one limit, and of the worst frame."""
NAMED_FROM = 110
"""Columns from which the main figures are followed by the names of their metrics."""

MOST_FIGURES = 6
PERCENT = ("track.missed_share", "track.false_share")
"""Main figures in percent."""

Screen = list[Line]


def commands_of(out: Path, *, recorded: bool, page: Path | None = None) -> dict[str, str]:
    """Return the next commands for a run folder, with what each shows; a `page` that is written already is named."""
    folder = shlex.quote(str(out))
    to_page = shlex.quote(str(page)) if page else f"luxloop report {folder}"
    pages = {to_page: "a page with pictures and all results"}
    if recorded:
        return {f"luxloop view {folder}": "the recording, at the worst frame", **pages}
    return {**pages, f"cat {shlex.quote(str(out / run_folder.REPORT))}": "the full report as text"}


def show_folder(result: Result, checks: Sequence[Check], out: Path, *, recorded: bool) -> None:
    """Print the screen of a run whose folder `out` is on disk; `recorded` if it can be viewed."""
    show(result, checks, commands_of(out, recorded=recorded), str(out / run_folder.REPORT))


def show(
    result: Result, checks: Sequence[Check], commands: Mapping[str, str], rest: str, facts: Sequence[str] = ()
) -> None:
    """Print the screen on standard output.

    Parameters
    ----------
    commands
        Next commands, with what each shows.
    rest
        Where the limits that do not fit are listed, e.g. the path of the full report.
    facts
        Facts that no metric has, for a line below the verdict.
    """
    print_lines(screen(result, checks, commands, rest, shutil.get_terminal_size().columns, facts))


def screen(
    result: Result,
    checks: Sequence[Check],
    commands: Mapping[str, str],
    rest: str,
    columns: int,
    facts: Sequence[str] = (),
) -> Screen:
    """Return at most `LINES` lines of at most this number of columns; only commands and paths may be longer.

    Other parameters are those of `show`.
    """
    columns = max(columns, NARROWEST)
    first = [*_head(result, checks, facts), *_warning(result, columns)]
    last = [
        figures(result.metrics, columns),
        _worst_frame(result, checks, columns),
        next_commands(commands, columns),
    ]
    room = LINES - BLANK - sum(map(len, [first, *last]))
    return spaced([section for section in (first, _failing(result, checks, rest, columns, room), *last) if section])


def spaced(sections: list[Screen]) -> Screen:
    """Join sections, with blank lines between them as far as these fit; the last ones first."""
    blank = LINES - sum(map(len, sections))
    lines: Screen = []
    for number, section in enumerate(sections):
        lines += [Line()] if 0 < number >= len(sections) - blank else []
        lines += section
    return lines


def headline(name: str, said: Answer) -> Line:
    """Return the first line: verdict, what was run, and the sentence about it."""
    return Line.of((said.verdict.upper(), f"{BOLD};{CODES[said.style]}"), "  ", (name, BOLD), f": {said.sentence}")


def figures(metrics: Mapping[str, Metric], columns: int) -> Screen:
    """Return the first `MOST_FIGURES` main figures that have a value, with their intervals."""
    shown = [name for name in ON_FIRST_SCREEN if name in metrics and metrics[name].value is not None][:MOST_FIGURES]
    if not shown:
        return []
    rows = [(ON_FIRST_SCREEN[name], *figure_cells(name, metrics[name])) for name in shown]
    lines = table(("Main figures", "value", "95 % interval"), rows)
    if columns >= NAMED_FROM:
        width = max(len(line.plain) for line in lines)
        names = [
            Piece(f"{'':<{width - len(line.plain) + 3}}{name}", DIM)
            for line, name in zip(lines[1:], shown, strict=True)
        ]
        return [lines[0], *(Line((*line.pieces, name)) for line, name in zip(lines[1:], names, strict=True))]
    return lines


def figure_cells(name: str, metric: Metric) -> tuple[str, str]:
    """Return value and interval of a main figure."""
    ends = "-".join(figure_text(name, end) for end in metric.interval) if metric.interval else interval_of(metric)
    unit = " %" if name in PERCENT else unit_of(metric)
    return figure_text(name, metric.value) + unit, ends


def figure_text(name: str, value: float | None) -> str:
    """Return a number of a main figure without its unit, with three significant digits but at most three decimals."""
    if value is None:
        return NONE
    shown = 100.0 * value if name in PERCENT else value
    if 0.1 <= abs(shown) < 1000.0:
        return f"{shown:#.3g}".rstrip(".")
    return f"{shown:.3f}" if abs(shown) < 0.1 else f"{shown:.0f}"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Screen:
    """Return a heading and rows: the first column to the left, the others to the right, numbers below each other."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]

    def line(cells: Sequence[str]) -> Line:
        others = (f"   {cell:>{width}}" for cell, width in zip(cells[1:], widths[1:], strict=True))
        return Line.of((f"  {cells[0]:<{widths[0]}}" + "".join(others)).rstrip())

    title = line((f"{head[0]:<{widths[0] + 2}}", *head[1:])).plain.strip()
    return [_heading(title), *(line(row) for row in rows)]


def next_commands(commands: Mapping[str, str], columns: int) -> Screen:
    """Return each command in one line, followed by its meaning where that fits."""
    width = max(map(len, commands), default=0)
    lines = []
    for command, meaning in commands.items():
        said = [f"   {meaning}"] if width + 3 + len(meaning) <= columns else []
        lines.append(Line.of((f"{command:<{width}}", f"{BOLD};{CYAN}"), *said))
    return lines


def _head(result: Result, checks: Sequence[Check], facts: Sequence[str]) -> Screen:
    """Return the verdict, the size of the run, and facts."""
    name = result.scenario if "recording" in result.config else f"{result.scenario}, seed {result.seed}"
    said = [counted(result.frames, "frame")]
    vehicles, time = (result.metrics[metric] for metric in ("dataset.vehicles", "perf.tracker_ms_p50"))
    said += [] if vehicles.value is None else [counted(round(vehicles.value), "vehicle")]
    said += [] if time.value is None else [f"tracker {value_of(time, 0)} ms a frame"]
    said += [] if result.config["device"] == SHIPPED else [f"device {result.config['device']}"]
    lines = [", ".join(line) for line in (said, facts) if line]
    return [headline(name, answer(result, checks)), *(Line.of((line, DIM)) for line in lines)]


def _warning(result: Result, columns: int) -> Screen:
    """Return the first warning about the traffic's input, cut to one line."""
    found = result.warnings
    more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
    if not found:
        return []
    line = textwrap.shorten(f"Warning: {found[0]}", max(columns - len(more), 10), placeholder=" ...")
    return [Line.of((line + more, CODES["warn"]))]


def _failing(result: Result, checks: Sequence[Check], rest: str, columns: int, room: int) -> Screen:
    """Return the limits that do not hold in at most `room` lines, unexpected ones and large excesses first."""
    found = unmet(checks)
    if not found:
        return []
    fitting = found if len(found) <= room - 1 else found[: room - 2]
    more = [Line.of((f"  and {len(found) - len(fitting)} more: {rest}", DIM))] if len(fitting) < len(found) else []
    for most in range(CAUSE_LINES, 0, -1):
        rows = _limit_rows(result, fitting, columns, most)
        if len(rows) + len(more) + 1 <= room or most == 1:
            break
    return [_failing_heading(found), *rows, *more]


def _failing_heading(found: Sequence[Check]) -> Line:
    """Return how many limits do not hold, and how many of them are known failures."""
    known = sum(check.outcome == "known failure" for check in found)
    of_them = "" if not known else ", a known failure" if known == len(found) == 1 else ", all known failures"
    of_them = f", {counted(known, 'known failure')} among them" if 0 < known < len(found) else of_them
    return _heading(f"{counted(len(found), 'limit does', 'limits do')} not hold{of_them}")


def _limit_rows(result: Result, checks: Sequence[Check], columns: int, most: int) -> Screen:
    """Return for each limit its metric, the value beside the limit, and the cause on `most` lines."""
    compared = [exceeded(check) for check in checks]
    name_width, width = max(len(check.name) for check in checks), max(map(len, compared))
    indent = 2 + name_width + 2 + width + 2
    lines = []
    for check, comparison in zip(checks, compared, strict=True):
        cause = textwrap.wrap(_cause(result, check), max(columns - indent, 10), max_lines=most, placeholder=" ...")
        style = CODES["bad" if check.outcome == "failed" else "warn"]
        named = (
            f"  {check.name:<{name_width}}  ",
            (f"{comparison:<{width}}  ", style),
            (cause[0] if cause else "", DIM),
        )
        lines += [Line.of(*named), *(Line.of((" " * indent + more, DIM)) for more in cause[1:])]
    return lines


def _cause(result: Result, check: Check) -> str:
    """Return the stated cause of a known failure; of others where it is worst, or else the need behind the limit."""
    if check.metric.reason:
        return check.metric.reason
    if check.outcome == "known failure":
        return expect.cause_of(check.limit.known_failure)
    worse = "worse than known; " if check.known else ""
    worst = worst_frames(result, check.name, count=1)
    return f"FAILED: {worse}" + (
        f"worst in {worst[0]}" if worst else check.limit.need or "no single frame is the cause"
    )


def _worst_frame(result: Result, checks: Sequence[Check], columns: int) -> Screen:
    """Return the frame that `luxloop view` opens at, and what is wrong in it."""
    found = frame_to_show(result, [check.name for check in unmet(checks)])
    lines = textwrap.wrap(f"Worst {found}", columns, max_lines=WORST_LINES, placeholder=" ...") if found else []
    return [Line.of((line[:5], BOLD), line[5:]) if n == 0 else Line.of(line) for n, line in enumerate(lines)]


def _heading(words: str) -> Line:
    return Line.of((words, BOLD))

"""Runs of one scenario with several seeds: verdicts, means and spreads, and the first screen."""

import math
import shutil
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from luxloop.scenarios.document.document import Answer, Document, Section, Span, Style, Table
from luxloop.scenarios.document.terminal import DIM, Line, print_lines
from luxloop.scenarios.files.expect import Check, unmet
from luxloop.scenarios.metrics.main_figures import OF_RUNS, ON_FIRST_SCREEN
from luxloop.scenarios.report import first_screen, text
from luxloop.scenarios.report.cells import NONE, exceeded, table_of, value_of
from luxloop.scenarios.report.first_screen import LINES, MOST_FIGURES, Screen
from luxloop.scenarios.report.html.reported_run import STYLES
from luxloop.scenarios.result import Result

WORST_FIRST = ("broken tracker", "failed", "incomplete", "no limits", "passed")
"""Verdicts of runs; that of all runs is the first of theirs."""
STYLE_OF: Mapping[str, Style] = {"broken tracker": "bad", **{str(one): style for one, style in STYLES.items()}}


def seeds_document(done: Mapping[int, Result], verdicts: Mapping[int, str]) -> Document:
    """Return runs that differ in their seeds.

    Parameters
    ----------
    done
        Runs that have a result, by seed.
    verdicts
        Verdict by seed, of all runs.
    """
    results = list(done.values())
    sections = [
        Section("each", "Each seed", [_each(results, verdicts)]),
        Section("spread", "Over the seeds", [_spread(results)]),
    ]
    return Document(seeds_name(done, verdicts), seeds_answer(verdicts), [], sections)


def seeds_name(done: Mapping[int, Result], verdicts: Mapping[int, str]) -> str:
    """Return the scenario and its seeds."""
    scenario = next((result.scenario for result in done.values()), "no run")
    return f"{scenario}, seeds {min(verdicts)}-{max(verdicts)}"


def seeds_answer(verdicts: Mapping[int, str]) -> Answer:
    """Return the worst verdict, and the number of seeds with each."""
    count = Counter(verdicts.values())
    present = [verdict for verdict in WORST_FIRST if count[verdict]]
    said = ", ".join(f"{count[verdict]} {verdict}" for verdict in present)
    return Answer(said, present[0], STYLE_OF[present[0]])


def summary(results: Sequence[Result]) -> dict[str, dict[str, Any]]:
    """Return mean, standard deviation and range over the seeds of each metric, for JSON; null without a value."""
    return {name: statistics_of(results, name) for name in (results[0].metrics if results else ())}


def statistics_of(results: Sequence[Result], name: str) -> dict[str, Any]:
    """Return mean, standard deviation and range of a metric over the seeds, its unit, and the seeds with a value."""
    found = [result.metrics[name].value for result in results]
    values = [value for value in found if value is not None]
    return {
        "mean": statistics.fmean(values) if values else None,
        "std": statistics.stdev(values) if len(values) > 1 else None,
        "min": min(values, default=None),
        "max": max(values, default=None),
        "unit": results[0].metrics[name].unit,
        "seeds": len(values),
    }


def _each(results: Sequence[Result], verdicts: Mapping[int, str]) -> Table:
    table = table_of("Each seed", "seed", *OF_RUNS.values())
    table.add_column("verdict", no_wrap=True)
    by_seed = {result.seed: result for result in results}
    for seed, verdict in verdicts.items():
        values = [value_of(by_seed[seed].metrics[name]) if seed in by_seed else NONE for name in OF_RUNS]
        table.add_row(str(seed), *values, Span(verdict, STYLE_OF[verdict]))
    return table


def _spread(results: Sequence[Result]) -> Table:
    """Return means and spreads of the main metrics and of those with expectations."""
    table = table_of("Over the seeds", "metric", "mean", "std", "least", "largest", "seeds")
    names = dict.fromkeys([*OF_RUNS, *(name for result in results for name in result.config["expect"])])
    for name in names if results else ():
        found = statistics_of(results, name)
        cells = [_number(found[part]) for part in ("mean", "std", "min", "max")]
        table.add_row(name, *cells, str(found["seeds"]))
    return table


def _number(value: float | None) -> str:
    return NONE if value is None or math.isnan(value) else f"{value:.3f}"


Runs = Mapping[int, Result]


def show(done: Runs, verdicts: Mapping[int, str], *, recorded: bool, full: bool) -> None:
    """Print the screen, or the tables of all seeds.

    Parameters
    ----------
    done
        Runs with a folder, by seed.
    verdicts
        Verdict by seed, of all runs.
    recorded
        True if the runs can be viewed.
    full
        True for the tables.
    """
    if full or not done:
        text.show(seeds_document(done, verdicts))
        return
    print_lines(screen(done, verdicts, shutil.get_terminal_size().columns, recorded=recorded))


def screen(done: Runs, verdicts: Mapping[int, str], columns: int, *, recorded: bool) -> Screen:
    """Return at most `LINES` lines; the parameters are those of `show`, and the columns of the terminal."""
    ranked = sorted(done, key=lambda seed: WORST_FIRST.index(verdicts[seed]))
    first, figures = [first_screen.headline(seeds_name(done, verdicts), seeds_answer(verdicts))], _figures(done)
    commands = first_screen.next_commands(_commands(done, ranked[0], recorded=recorded), columns)
    failing = _failing(done, LINES - len(first) - len(figures) - len(commands) - first_screen.BLANK)
    return first_screen.spaced([section for section in (first, failing, figures, commands) if section])


def _figures(done: Runs) -> Screen:
    """Return mean, spread and range over the seeds of the main figures."""
    found = {name: statistics_of(list(done.values()), name) for name in ON_FIRST_SCREEN}
    shown = [name for name, figure in found.items() if figure["seeds"]][:MOST_FIGURES]
    parts = ("mean", "std", "min", "max")
    rows = [
        (ON_FIRST_SCREEN[name], *(first_screen.figure_text(name, found[name][part]) for part in parts))
        for name in shown
    ]
    return first_screen.table(("Main figures", "mean", "std", "least", "largest"), rows) if rows else []


def _failing(done: Runs, room: int) -> Screen:
    """Return the limits that do not hold, the worst first: worst value, and in how many seeds."""
    by_name: dict[str, dict[int, Check]] = {}
    for seed, run in done.items():
        for check in unmet(run.checks):
            by_name.setdefault(check.name, {})[seed] = check
    worst = {name: min(found, key=lambda seed: _importance(found[seed])) for name, found in by_name.items()}
    names = sorted(by_name, key=lambda name: _importance(by_name[name][worst[name]]))
    shown = names if len(names) < room else names[: room - 2]
    rows = [_row(name, by_name[name], worst[name], len(done)) for name in shown]
    more = (
        [Line.of((f"  and {len(names) - len(shown)} more: --full prints all", DIM))] if len(shown) < len(names) else []
    )
    return [*first_screen.table(("Limits that do not hold", "worst", "seeds"), rows), *more] if rows else []


def _importance(check: Check) -> tuple[bool, float]:
    """Return the key for an order with failures before known failures, and large excesses first."""
    return check.outcome != "failed", -check.excess


def _row(name: str, found: Mapping[int, Check], worst: int, seeds: int) -> tuple[str, str, str]:
    failed = sum(check.outcome == "failed" for check in found.values())
    known = "" if failed else "known failure, "
    return name, exceeded(found[worst]), f"{known}{len(found)} of {seeds} seeds, worst: {worst}"


def _commands(done: Runs, worst: int, *, recorded: bool) -> dict[str, str]:
    """Return the commands that show the worst run and all runs."""
    folder = done[worst].out
    assert folder is not None
    of_worst = first_screen.commands_of(folder, recorded=recorded)
    if not recorded:
        return of_worst
    view = next(iter(of_worst))
    return {view: f"the recording of seed {worst}", **dict(list(of_worst.items())[1:])}

"""Screen of `luxloop run --seeds`: verdicts, main figures over the seeds, limits that do not hold, next commands."""

from collections.abc import Mapping, Sequence

from rich.console import Console
from rich.text import Text

from luxloop.scenarios.files.expect import Check, unmet
from luxloop.scenarios.report import first_screen, text
from luxloop.scenarios.report.cells import exceeded
from luxloop.scenarios.report.first_screen import FIGURES, LINES, MOST_FIGURES, Screen
from luxloop.scenarios.report.seed_table import WORST_FIRST, seeds_answer, seeds_document, seeds_name, statistics_of
from luxloop.scenarios.result import Result

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
    console = Console(markup=False, emoji=False, highlight=False)
    first_screen.print_lines(screen(done, verdicts, console.width, recorded=recorded), console)


def screen(done: Runs, verdicts: Mapping[int, str], columns: int, *, recorded: bool) -> Screen:
    """Return at most `LINES` lines; the parameters are those of `show`, and the columns of the terminal."""
    ranked = sorted(done, key=lambda seed: WORST_FIRST.index(verdicts[seed]))
    first, figures = [first_screen.headline(seeds_name(done, verdicts), seeds_answer(verdicts))], _figures(done)
    commands = first_screen.next_commands(_commands(done, ranked[0], recorded=recorded), columns)
    failing = _failing(done, LINES - len(first) - len(figures) - len(commands) - first_screen.BLANK)
    return first_screen.spaced([section for section in (first, failing, figures, commands) if section])


def _figures(done: Runs) -> Screen:
    """Return mean, spread and range over the seeds of the main figures."""
    found = {name: statistics_of(list(done.values()), name) for name in FIGURES}
    shown = [name for name, figure in found.items() if figure["seeds"]][:MOST_FIGURES]
    parts = ("mean", "std", "min", "max")
    rows = [(FIGURES[name], *(first_screen.figure_text(name, found[name][part]) for part in parts)) for name in shown]
    return first_screen.table(("Main figures", "mean", "std", "least", "largest"), rows) if rows else []


def _failing(done: Runs, room: int) -> Screen:
    """Return the limits that do not hold, the worst first: worst value, and in how many seeds."""
    by_name: dict[str, dict[int, Check]] = {}
    for seed, run in done.items():
        for check in unmet(run.checks):
            by_name.setdefault(check.name, {})[seed] = check
    worst = {name: _worst_seed(found) for name, found in by_name.items()}
    names = sorted(by_name, key=lambda name: _importance(by_name[name][worst[name]]))
    shown = names if len(names) < room else names[: room - 2]
    rows = [_row(name, by_name[name], worst[name], len(done)) for name in shown]
    more = [Text(f"  and {len(names) - len(shown)} more: --full prints all", "dim")] if len(shown) < len(names) else []
    return [*_table(rows), *more] if rows else []


def _worst_seed(found: Mapping[int, Check]) -> int:
    return min(found, key=lambda seed: _importance(found[seed]))


def _importance(check: Check) -> tuple[bool, float]:
    """Return the key for an order with failures before known failures, and large excesses first."""
    return check.outcome != "failed", -check.excess


def _row(name: str, found: Mapping[int, Check], worst: int, seeds: int) -> tuple[str, str, str]:
    failed = sum(check.outcome == "failed" for check in found.values())
    known = "" if failed else "known failure, "
    return name, exceeded(found[worst]), f"{known}{len(found)} of {seeds} seeds, worst: {worst}"


def _table(rows: Sequence[tuple[str, str, str]]) -> Screen:
    return first_screen.table(("Limits that do not hold", "worst", "seeds"), rows)


def _commands(done: Runs, worst: int, *, recorded: bool) -> dict[str, str]:
    """Return the commands that show the worst run and all runs."""
    folder = done[worst].out
    assert folder is not None
    of_worst = first_screen.commands_of(folder, recorded=recorded)
    if not recorded:
        return of_worst
    view = next(iter(of_worst))
    return {view: f"the recording of seed {worst}", **dict(list(of_worst.items())[1:])}

"""Folder of a league: its page, rows and picture."""

import json
import math
import shlex
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from luxloop.scenarios.document import html
from luxloop.scenarios.document.document import (
    Answer,
    Block,
    Bullets,
    Document,
    Facts,
    Paragraph,
    Preformatted,
    Section,
    Table,
    json_data,
)
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import BLUE, INK, LINE, MUTED
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.league.drive import SCANS
from luxloop.scenarios.league.entrants import Entrant, chosen
from luxloop.scenarios.league.league_runs import Row
from luxloop.scenarios.league.standings import GOSPA, PairedDifference, Standing, ahead, beaten_in
from luxloop.scenarios.report.cells import NONE, table_of
from luxloop.scenarios.run.device import REFERENCE
from luxloop.scenarios.study.row_store import LOCK, ROWS

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


SHORT = {
    "track.hota": "HOTA", "track.id_switch_rate": "id switches per observation", "track.false_share": "false rate",
    "track.missed_share": "missed rate", GOSPA: "GOSPA [m]",
}  # fmt: skip


def standings_table(found: Sequence[Standing]) -> Table:
    """Return the figures of each tracker, the highest HOTA first."""
    columns = ("HOTA", "95 %", "id switches", "GOSPA [m]", "false", "missed", "step time", "runs", "failed")
    table = table_of("Standings", "tracker", *columns)
    for each in found:
        counts = [str(each.counts[name]) if each.runs else NONE for name in ("id_switches", "false", "missed")]
        table.add_row(
            each.tracker,
            number(each.hota),
            interval(each.hota_interval),
            counts[0],
            number(each.gospa_m),
            *counts[1:],
            NONE if math.isnan(each.step_ratio) else f"{each.step_ratio:.2f}x",
            str(each.runs),
            str(each.failed),
            style="bold" if each.tracker == REFERENCE else "",
        )
    return table


def differences_table(found: Sequence[Standing]) -> Table:
    """Return the paired differences to the shipped tracker; intervals without 0 have a star."""
    table = table_of("Differences to the shipped tracker, 95 % intervals", "tracker", *SHORT.values())
    for each in found:
        if each.differences:
            table.add_row(each.tracker, *(_difference(each.differences[name]) for name in SHORT))
    return table


def scenario_table(found: Sequence[Standing]) -> Table:
    """Return HOTA by scenario."""
    table = table_of("HOTA by scenario", "scenario", *(each.tracker for each in found))
    for scenario in sorted({name for each in found for name in each.hota_by_scenario}):
        values = [each.hota_by_scenario.get(scenario, math.nan) for each in found]
        best = max((value for value in values if math.isfinite(value)), default=math.nan)
        table.add_row(scenario, *(f"{number(value)}{' *' if value == best else ''}" for value in values))
    return table


def entrants_table(trackers: Sequence[Entrant]) -> Table:
    """Return association, filter and settings of each tracker."""
    table = table_of("Trackers", "tracker", "method", "settings other than the defaults")
    for entrant in trackers:
        table.add_row(entrant.name, entrant.text, ", ".join(f"{k} {v}" for k, v in entrant.settings.items()) or "none")
    return table


def failures_table(rows: Sequence[Row]) -> Table:
    """Return the runs without a result, with their errors."""
    table = table_of("Runs without a result", "run", "error")
    for row in rows:
        if row["status"] != "finished":
            table.add_row(f"{row['tracker']}, {row['scenario']} seed {row['seed']}", f"{row['status']}: {row['error']}")
    return table


def number(value: float) -> str:
    """Return a figure with three decimals."""
    return f"{value:.3f}" if math.isfinite(value) else NONE


def interval(ends: tuple[float, float]) -> str:
    """Return an interval; empty without one."""
    return f"{ends[0]:.3f} to {ends[1]:.3f}" if math.isfinite(ends[0]) else ""


def _difference(each: PairedDifference) -> str:
    if not math.isfinite(each.difference):
        return NONE
    low, high = each.interval
    spread = f" ({low:+.3f} to {high:+.3f})" if math.isfinite(low) else ""
    return f"{each.difference:+.3f}{spread}{' *' if each.clear else ''}"


CAPTION = (
    "Dots are HOTA over all vehicles of all runs, lines 95 % intervals over vehicles; the shipped tracker is blue."
)


def hota_figure(found: Sequence[Standing]) -> Figure:
    """Draw HOTA of each tracker, the highest first."""
    shown = [each for each in found if math.isfinite(each.hota)]

    def on(canvas: "Canvas") -> None:
        axes = canvas.subplots()
        for row, each in enumerate(shown):
            color = BLUE if each.tracker == REFERENCE else INK
            axes.axhline(row, color=LINE, lw=0.4)
            if math.isfinite(each.hota_interval[0]):
                axes.plot(each.hota_interval, [row, row], color=color, lw=2.0, solid_capstyle="butt")
            axes.plot(each.hota, row, "o", color=color, ms=6)
            axes.annotate(
                f"{each.hota:.3f}", (each.hota, row), (0, 6), textcoords="offset points", ha="center", color=MUTED
            )
        axes.set_yticks(range(len(shown)), [each.tracker for each in shown])
        axes.set(xlim=(0.0, 1.0), ylim=(len(shown) - 0.5, -0.7), xlabel="HOTA")
        axes.grid(visible=False, axis="y")

    return Figure("hota", "HOTA of each tracker", CAPTION, (5.4, 0.9 + 0.36 * max(len(shown), 2)), on)


PAGE, TABLE, DOCUMENT = "league.html", "league.csv", "league.json"
EXPLANATIONS = (
    "All trackers got the same recorded scans and were graded by the same grader.",
    "The 95 % intervals of HOTA and of differences follow from their spread as each vehicle is left out in turn, those "
    "of GOSPA as each run is left out. A star marks an interval without 0; it is for that comparison alone.",
    "Step time is the median over the runs of the median time of a step, with detection, as a multiple of the shipped "
    "tracker's in the same run.",
    "The peers get the boxes of the shipped detector. Their settings were tuned on other scenarios by the same small "
    "budget; the shipped tracker was developed on this simulator for longer.",
)

STAGES_OF = "The errors that each of its stages causes in these scenarios:"


@dataclass(frozen=True, slots=True)
class Request:
    """Arguments of the command, for the page."""

    scenarios: tuple[str, ...]
    seeds: tuple[int, ...]
    duration_max_s: float
    trackers: tuple[str, ...]


def write(rows: Sequence[Row], found: Sequence[Standing], request: Request, out: Path) -> Document:
    """Write page, rows, JSON and picture, and return the document.

    Raises
    ------
    OutputError
        A file cannot be written.
    """
    document = league_document(rows, found, request)
    html.write(out / PAGE, document)
    atomic_file.save_text(out / TABLE, pd.DataFrame(list(rows)).to_csv(index=False))
    atomic_file.save_text(out / DOCUMENT, json.dumps(json_data(document), indent=1, allow_nan=False) + "\n")
    hota_figure(found).save(out, ["svg", "png"])
    return document


def league_document(rows: Sequence[Row], found: Sequence[Standing], request: Request) -> Document:
    """Return a league as a document."""
    failed = any(row["status"] != "finished" for row in rows)
    commands, worse = blame_commands(found, request), behind(found)
    facts = {
        "trackers": str(len(found)),
        "scenarios": str(len(request.scenarios)),
        "seeds": ", ".join(map(str, request.seeds)),
        "longest run": f"{request.duration_max_s:g} s",
    }
    trackers = entrants_table(chosen(request.trackers))
    why: list[Block] = [Paragraph(STAGES_OF), Preformatted("\n".join(commands))]
    details = [trackers, *([failures_table(rows)] if failed else [])]
    differences = [differences_table(found), scenario_table(found)]
    sections = [
        Section("standings", "Standings", [standings_table(found)]),
        Section("behind", "Where the shipped tracker is not the best", [Bullets(worse)] if worse else []),
        Section("blame", "Why", why if commands else []),
        Section("differences", "Differences", [*differences, Bullets(EXPLANATIONS)], page_only=True),
        Section("details", "Trackers and runs", details, page_only=True),
        Section("again", "Reproduce", [Preformatted(_command(request))], page_only=True),
    ]
    return Document(
        title=f"League of {len(found)} trackers",
        answer=Answer(lead(found)),
        lead=[hota_figure(found), Facts(facts)],
        sections=sections,
        data=_data(rows, found, request),
    )


def lead(found: Sequence[Standing]) -> str:
    """Return the result in one sentence."""
    first, shipped = found[0], next(each for each in found if each.tracker == REFERENCE)
    if first is shipped:
        worse = [each for each in found if each.differences and each.differences["track.hota"].clear]
        return (
            f"The shipped tracker has the highest HOTA, {shipped.hota:.3f}; "
            f"{len(worse)} of {len(found) - 1} others are behind beyond chance (95 %)"
        )
    return f"The shipped tracker is not the best: {first.tracker} has HOTA {first.hota:.3f}, it has {shipped.hota:.3f}"


def behind(found: Sequence[Standing]) -> list[str]:
    """Return a sentence for each metric and scenario in which the shipped tracker is not the best."""
    lines = []
    for metric, better in ahead(found).items():
        names = ", ".join(
            f"{each.tracker}{'' if each.differences[metric].clear else ' (not clear)'}" for each in better
        )
        lines.append(f"{SHORT[metric]}: better than the shipped tracker: {names}.")
    shipped = next(each for each in found if each.tracker == REFERENCE)
    for scenario, each in beaten_in(found).items():
        values = f"{each.hota_by_scenario[scenario]:.3f} against {shipped.hota_by_scenario[scenario]:.3f}"
        lines.append(f"HOTA in {scenario}: {each.tracker} has {values}.")
    return lines


def blame_commands(found: Sequence[Standing], request: Request) -> list[str]:
    """Return the commands that show which stage of the shipped tracker causes its errors."""
    files = {Path(name).stem: name for name in request.scenarios}
    return [
        shlex.join(["luxloop", "blame", files.get(scenario, scenario), "--seed", str(request.seeds[0]),
                    "--duration", f"{request.duration_max_s:g}"])
        for scenario in beaten_in(found)
    ]  # fmt: skip


def _data(rows: Sequence[Row], found: Sequence[Standing], request: Request) -> dict[str, Any]:
    """Return the standings and the rows for programs."""
    tables = [{k: v for k, v in _fields(each).items() if k != "comparison"} for each in found]
    return {
        **asdict(request), "behind": behind(found), "blame": blame_commands(found, request),
        "standings": tables, "rows": list(rows),
    }  # fmt: skip


def _fields(each: Standing) -> dict[str, Any]:
    values = {name: getattr(each, name) for name in each.__dataclass_fields__}
    return {**values, "differences": {name: asdict(value) for name, value in each.differences.items()}}


def _command(request: Request) -> str:
    seeds = ",".join(map(str, request.seeds))
    trackers = [word for spec in request.trackers for word in ("--trackers", spec)]
    options = ["--seeds", seeds, "--duration", f"{request.duration_max_s:g}"]
    return shlex.join(["luxloop", "league", *request.scenarios, *options, *trackers])


def refuse_other_files(out: Path) -> None:
    """Raise an OutputError if `out` is a file, or holds other files than those of a league.

    A league that was killed early has a lock file and maybe scans, and nothing else.
    """
    if not out.exists():
        return
    if not out.is_dir():
        raise OutputError(f"{out}: is a file; choose another folder with --out")
    names = {path.name for path in out.iterdir()}
    begun = (out / ROWS).is_file() or (out / DOCUMENT).is_file()
    if not begun and not names <= {SCANS, LOCK}:
        raise OutputError(f"{out}: holds other files than those of a league; choose another folder with --out")
    if (out / SCANS).is_file():
        raise OutputError(f"{out / SCANS}: is a file, but a league has a folder there; choose another with --out")

"""`luxloop league`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import AsJson, Quiet, Workers, finite, require, worker_count

if TYPE_CHECKING:
    from luxloop.scenarios.league.drive import Drive
    from luxloop.scenarios.league.league_runs import Row

SCENARIOS = (
    "sumo-crossing", "two-lane-roundabout", "t-junction", "queue-discharge", "intersection-v0", "parked-row",
    "free-flow", "motorway-jam", "truck-shadow", "cross-traffic-behind-bus",
)  # fmt: skip
"""Scenarios of a league without arguments: city, motorway and occlusions, none of them used to tune the peers."""
DURATION_S = 8.0


def league(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(metavar="[SCENARIO]...", help=f"Names or paths; {len(SCENARIOS)} shipped ones if left out."),
    ] = None,
    seeds: Annotated[
        str, typer.Option(metavar="SEED,...", help="Seeds, separated by commas, or the first and the last, e.g. 1-6.")
    ] = "11,12,13",
    duration: Annotated[
        float, typer.Option(min=0.1, callback=finite, help="Simulated seconds of each run at most.")
    ] = DURATION_S,
    trackers: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME,...",
            help="Some of the trackers, and your own as FILE.py:NAME, MODULE:NAME or process:COMMAND; may be repeated.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of scans, runs and page.")] = Path("league"),
    workers: Workers = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Run several trackers on the same recorded scans and compare them on one page. A second start continues.

    Exit code: 0 if all runs have a result, 1 if a tracker or the traffic failed in one; its row names the error.
    """
    from luxloop.scenarios.document.document import json_text
    from luxloop.scenarios.league import league_page
    from luxloop.scenarios.league.drive import drives
    from luxloop.scenarios.league.entrants import chosen
    from luxloop.scenarios.league.league_page import Request, refuse_other_files
    from luxloop.scenarios.league.standings import standings
    from luxloop.scenarios.report import text

    wanted = [spec for text in trackers or [] for spec in _specs(text)]
    trackers_chosen = chosen(wanted)
    for extra in filter(None, dict.fromkeys(each.extra for each in trackers_chosen)):
        require("league", extra)
    entrants = tuple(each.spec for each in trackers_chosen)
    request = Request(tuple(scenarios or SCENARIOS), _seeds(seeds), duration, entrants)
    todo = drives(request.scenarios, request.seeds, duration, wanted, out)
    refuse_other_files(out)
    rows = _run(todo, worker_count(workers, None), quiet or as_json)
    found = standings(rows, out)
    document = league_page.write(rows, found, request, out)
    if as_json:
        print_text(json_text(document, out=str(out)))
    elif not quiet:
        text.show(document)
        print_text(f"The page is {out / league_page.PAGE}, a row per run in {out / league_page.TABLE}")
    raise typer.Exit(1 if any(row["status"] != "finished" for row in rows) else 0)


def _specs(text: str) -> list[str]:
    """Return the trackers of "NAME,FILE.py:NAME"; a command may contain commas."""
    return [text] if text.startswith("process:") else text.split(",")


def _seeds(text: str) -> tuple[int, ...]:
    """Return the seeds of "11,12,13" or "1-6", each once.

    Raises
    ------
    InputError
        The text is neither.
    """
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.files import option_values

    try:
        return tuple(dict.fromkeys(seed for part in text.split(",") for seed in option_values.parse_seeds(part)))
    except InputError as error:
        raise InputError(f"--seeds {text}: give seeds as 11,12,13 or the first and the last as 1-6") from error


def _run(todo: "list[Drive]", workers: int, hide: bool) -> "list[Row]":
    """Run all drives with a progress bar, and return their rows in the order of the request."""
    from concurrent.futures.process import BrokenProcessPool

    from luxloop.scenarios.errors import InputError, Interrupted
    from luxloop.scenarios.league.entrants import chosen
    from luxloop.scenarios.league.league_runs import carry_out
    from luxloop.scenarios.run.progress import hidden, runs

    rows: list[Row] = []
    drives = {(drive.stem, drive.seed): number for number, drive in enumerate(todo)}
    trackers = {each.name: number for number, each in enumerate(chosen(todo[0].trackers))}
    try:
        with hidden(hide), runs("league", len(drives) * len(trackers)) as finish:
            for row in carry_out(todo, workers):
                rows.append(row)
                finish(1)
    except KeyboardInterrupt as error:
        kept = f"{len(rows)} of {len(drives) * len(trackers)} rows are in {todo[0].out}"
        raise Interrupted(f"interrupted; {kept}; run the same command to resume") from error
    except BrokenProcessPool as error:
        reason = "a worker process died: out of memory, or killed"
        raise InputError(f"{reason}; the same command continues, with fewer --workers if memory is short") from error
    return sorted(rows, key=lambda row: (drives[row["scenario"], row["seed"]], trackers[row["tracker"]]))

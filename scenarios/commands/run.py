"""`luxloop run`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.scenarios.commands.arguments import (
    DEFAULT_STEP_TIMEOUT_S,
    AsJson,
    Duration,
    Quiet,
    ScenarioName,
    Seed,
    StepTimeout,
    Tracker,
)
from luxloop.scenarios.oracle.stage import Stage

if TYPE_CHECKING:
    from luxloop.scenarios.commands.run_request import RunRequest


def run(
    scenario: ScenarioName,
    seed: Seed = None,
    seeds: Annotated[
        str | None,
        typer.Option(metavar="FIRST-LAST", help="Run all these seeds, e.g. 1-6, and print means and spreads."),
    ] = None,
    duration: Duration = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Replace any key of the scenario, e.g. noise.ideal=true; may be repeated.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results, with --seeds of all runs; in runs if left out.")
    ] = None,
    tracker: Tracker = None,
    oracle: Annotated[
        list[Stage] | None,
        typer.Option(
            metavar="STAGE",
            help=f"Replace a stage of the shipped tracker ({', '.join(Stage)}) with the ground truth; may be repeated.",
        ),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    no_recording: Annotated[bool, typer.Option("--no-recording", help="Write no recording.rrd.")] = False,
    record_scans: Annotated[
        bool,
        typer.Option("--record-scans", help="Keep scans and ground truth with the run, for luxloop grade."),
    ] = False,
    dataset_to: Annotated[
        Path | None, typer.Option("--dataset", metavar="DIR", help="Also write scans and labels into this new folder.")
    ] = None,
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S,
    ahead: Annotated[
        bool | None,
        typer.Option(
            "--ahead/--no-ahead",
            show_default=False,
            help="Run traffic and LIDARs ahead of the tracker in another process; the default with a second core.",
        ),
    ] = None,
) -> None:
    """Run a scenario, grade it, and exit with 1 if an expectation fails; with --seeds, with the worst run's code."""
    from luxloop.scenarios.commands.run_request import RunRequest
    from luxloop.scenarios.run.progress import hidden

    request = RunRequest(
        scenario, duration, settings or [], out, tracker, oracle or [], not no_recording, record_scans, dataset_to,
        step_timeout, ahead,
    )  # fmt: skip
    with hidden(quiet):
        if seeds is None:
            code = _run_one(request, seed, as_json, quiet)
        else:
            code = _run_each(request, seed, seeds, as_json, quiet)
    raise typer.Exit(code)


def _run_one(request: "RunRequest", seed: int | None, as_json: bool, quiet: bool) -> int:
    """Run one seed, print the report or JSON, and return the exit code."""
    import json

    outcome = request.execute(seed)
    from luxloop.scenarios.commands.run_seeds import code_of
    from luxloop.scenarios.report import text
    from luxloop.scenarios.run import run_folder

    if as_json:
        document = run_folder.document(outcome.result, outcome.checks)
        print(json.dumps({**document, "out": str(outcome.out)}, allow_nan=False))
    elif not quiet:
        text.show(outcome.report, outcome.text)
        view = f"; to view them: luxloop view {outcome.out}" if request.record else ""
        print(f"Results are in {outcome.out}{view}")
        if request.dataset_to:
            print(f"The data set is in {request.dataset_to}")
    return code_of(outcome)


def _run_each(request: "RunRequest", seed: int | None, seeds: str, as_json: bool, quiet: bool) -> int:
    """Run several seeds, print their tables or JSON, and return the exit code of the worst."""
    import json

    from luxloop.scenarios.commands.run_seeds import run_seeds
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.files import seed_range
    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.seed_table import seed_report

    if seed is not None:
        raise InputError("--seed and --seeds are both given; omit one")
    request.require_own_folders()
    every = seed_range.parse(seeds)
    request.load(every[-1])  # the largest seed may be too large
    found = run_seeds(every, request, (lambda _: None) if as_json or quiet else _print_now)
    if as_json:
        print(json.dumps(found.document(), allow_nan=False))
    elif not quiet:
        text.show(seed_report([run.result for run in found.done.values()], found.verdicts))
    return found.code


def _print_now(line: str) -> None:
    print(line, flush=True)

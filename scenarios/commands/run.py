"""`luxloop run`."""

from pathlib import Path
from typing import Annotated

import typer

from scenarios.commands.arguments import (
    DEFAULT_STEP_TIMEOUT_S,
    AsJson,
    Duration,
    ScenarioName,
    Seed,
    StepTimeout,
    Tracker,
    overrides,
)
from scenarios.commands.error_line import print_early_end
from scenarios.oracle.stage import Stage


def run(
    scenario: ScenarioName,
    seed: Seed = None,
    duration: Duration = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; runs/SCENARIO-seedN if left out.")] = None,
    tracker: Tracker = None,
    oracle: Annotated[
        list[Stage] | None,
        typer.Option(help="Replace this stage of the shipped tracker with the ground truth; may be repeated."),
    ] = None,
    as_json: AsJson = False,
    no_recording: Annotated[bool, typer.Option("--no-recording", help="Write no recording.rrd.")] = False,
    record_scans: Annotated[
        bool,
        typer.Option("--record-scans", help="Keep scans and ground truth with the run, for luxloop grade."),
    ] = False,
    dataset_to: Annotated[
        Path | None, typer.Option("--dataset", metavar="DIR", help="Also write scans and labels into this new folder.")
    ] = None,
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S,
) -> None:
    """Run a scenario, grade it, and exit with 1 if an expectation fails."""
    import json

    from scenarios.execute import default_folder, execute
    from scenarios.files import shipped
    from scenarios.files.scenario import Scenario
    from scenarios.oracle.device_choice import choose
    from scenarios.report import text
    from scenarios.run import run_folder

    chosen = Scenario.load(shipped.find(scenario), overrides(seed, duration))
    make_device = choose(tracker, oracle or [])
    out = out or default_folder(chosen, oracle or [])
    outcome = execute(
        chosen,
        make_device,
        out,
        record=not no_recording,
        record_scans=record_scans,
        dataset_to=dataset_to,
        step_timeout_s=step_timeout,
    )
    result, code = outcome.result, 0 if outcome.verdict == "passed" else 1
    if as_json:
        print(json.dumps({**run_folder.document(result, outcome.checks), "out": str(out)}, allow_nan=False))
    else:
        text.show(outcome.report)
        print(f"Results are in {out}" + ("" if no_recording else f"; to view them: luxloop view {out}"))
        if dataset_to:
            print(f"The data set is in {dataset_to}")
    if not result.complete:
        code = print_early_end(result, f"the {result.frames} frames until then are in {out}, marked incomplete")
    raise typer.Exit(code)

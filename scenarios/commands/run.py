"""`luxloop run`."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import (
    DEFAULT_STEP_TIMEOUT_S,
    AsJson,
    Duration,
    Full,
    Quiet,
    ScenarioName,
    Seed,
    StepTimeout,
    Tracker,
    grouped,
)
from luxloop.scenarios.commands.error_messages import print_early_end, print_error
from luxloop.scenarios.errors import ContractError, InputError, Interrupted
from luxloop.scenarios.files import option_values
from luxloop.scenarios.oracle.stage import Stage

if TYPE_CHECKING:
    from luxloop.scenarios.result import Result


RUNS = "runs"
"""Folder of the runs without --out."""


@dataclass(frozen=True, slots=True)
class DeviceOptions:
    """The tracker under test."""

    tracker: Tracker = None
    oracle: Annotated[
        list[Stage] | None,
        typer.Option(
            metavar="STAGE",
            help=f"Replace a stage of the shipped tracker ({', '.join(Stage)}) with the ground truth; may be repeated.",
        ),
    ] = None
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S
    in_process: Annotated[
        bool,
        typer.Option("--in-process", help="Run a tracker of your own in this process, for a debugger; not comparable."),
    ] = False


@dataclass(frozen=True, slots=True)
class Kept:
    """Files of the results."""

    out: Annotated[
        Path | None, typer.Option(help="Folder of the results, with --seeds of all runs; in runs if left out.")
    ] = None
    no_recording: Annotated[bool, typer.Option("--no-recording", help="Write no recording.rrd.")] = False
    record_scans: Annotated[
        bool,
        typer.Option("--record-scans", help="Keep scans and ground truth with the run, for luxloop grade."),
    ] = False
    dataset_to: Annotated[
        Path | None, typer.Option("--dataset", metavar="DIR", help="Also write scans and labels into this new folder.")
    ] = None


@dataclass(frozen=True, slots=True)
class Printed:
    """Output on the terminal."""

    as_json: AsJson = False
    quiet: Quiet = False
    full: Full = False


DEFAULT_DEVICE, DEFAULT_KEPT, DEFAULT_PRINTED = DeviceOptions(), Kept(), Printed()


@grouped
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
    device: DeviceOptions = DEFAULT_DEVICE,
    kept: Kept = DEFAULT_KEPT,
    printed: Printed = DEFAULT_PRINTED,
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
    from luxloop.scenarios import interface

    changes: dict[str, Any] = {"duration_s": duration, "settings": settings or []}
    run_seed = partial(
        interface.run, scenario, **changes, tracker=device.tracker, oracles=device.oracle or [],
        record=not kept.no_recording, record_scans=kept.record_scans, dataset_to=kept.dataset_to,
        step_timeout_s=device.step_timeout, ahead=ahead, in_process=device.in_process, progress=not printed.quiet,
    )  # fmt: skip
    if seeds is None:
        code = _show(run_seed(seed=seed, out=kept.out, into=None if kept.out else RUNS), kept, printed)
    else:
        _refuse_with_seeds(seed, kept.dataset_to)
        every = option_values.parse_seeds(seeds)
        interface.load_scenario(scenario, **changes, seed=every[-1])  # the largest seed may be too large
        code = _run_each(every, partial(run_seed, into=kept.out or RUNS), kept, printed)
    raise typer.Exit(code)


def _show(result: "Result", kept: Kept, printed: Printed) -> int:
    """Print the screen or JSON of a run, and return the exit code."""
    import json

    from luxloop.scenarios.report import first_screen, text
    from luxloop.scenarios.run import run_folder

    if printed.as_json:
        print_text(json.dumps({**run_folder.document(result, result.checks), "out": str(result.out)}, allow_nan=False))
    elif not printed.quiet:
        assert result.out is not None
        if printed.full:
            text.show(text.report(result, result.checks))
            print_text(f"Results are in {result.out}")
        else:
            first_screen.show_folder(result, result.checks, result.out, recorded=not kept.no_recording)
        if kept.dataset_to:
            print_text(f"The data set is in {kept.dataset_to}")
    return code_of(result)


def _refuse_with_seeds(seed: int | None, dataset: Path | None) -> None:
    """Raise an InputError for options of a single run."""
    if seed is not None:
        raise InputError("--seed and --seeds are both given; omit one")
    if dataset:
        raise InputError("--seeds and --dataset are both given; omit one, a data set is of one run")


def _run_each(seeds: Sequence[int], run_seed: Callable[..., "Result"], kept: Kept, printed: Printed) -> int:
    """Run several seeds, print their tables or JSON, and return the exit code of the worst."""
    import json

    from luxloop.scenarios.report import seeds_document

    found = run_seeds(seeds, run_seed, (lambda _: None) if printed.as_json or printed.quiet else _print_now)
    if printed.as_json:
        print_text(json.dumps(found.document(), allow_nan=False))
    elif not printed.quiet:
        seeds_document.show(found.done, found.verdicts, recorded=not kept.no_recording, full=printed.full)
    return found.code


def _print_now(line: str) -> None:
    print_text(line, file=sys.stderr, flush=True)


BROKEN_TRACKER = 4


@dataclass(slots=True)
class SeedRuns:
    """Runs of one scenario with several seeds."""

    done: dict[int, "Result"] = field(default_factory=dict)
    """Runs with a folder, by seed."""
    errors: dict[int, str] = field(default_factory=dict)
    """Messages of the runs in which the tracker broke its contract, by seed."""
    code: int = 0
    """Exit code of the worst run."""

    @property
    def verdicts(self) -> dict[int, str]:
        """Verdict by seed, in their order."""
        found = {seed: run.verdict for seed, run in self.done.items()} | dict.fromkeys(self.errors, "broken tracker")
        return dict(sorted(found.items()))

    def document(self) -> dict[str, Any]:
        """Return the JSON document of all runs."""
        from luxloop.scenarios.report.seeds_document import summary
        from luxloop.scenarios.run import run_folder

        runs = [{**run_folder.document(run, run.checks), "out": str(run.out)} for run in self.done.values()]
        errors = [{"seed": seed, "error": message} for seed, message in self.errors.items()]
        found = summary(list(self.done.values()))
        return {"exit_code": self.code, "runs": runs, "errors": errors, "summary": found}


def run_seeds(seeds: Sequence[int], run: Callable[..., "Result"], say: Callable[[str], None]) -> SeedRuns:
    """Run a scenario with each seed; a broken contract ends the run of one seed only.

    Parameters
    ----------
    seeds
        Seeds, in this order.
    run
        Runs the scenario with the argument `seed`.
    say
        Takes a line about each run that has ended.

    Raises
    ------
    Interrupted
        Ctrl-C after the first run.
    """
    found = SeedRuns()
    for seed in seeds:
        try:
            result = run(seed=seed)
        except ContractError as error:
            found.errors[seed] = str(error)
            found.code = max(found.code, print_error(f"seed {seed}: {error}", BROKEN_TRACKER))
            continue
        except KeyboardInterrupt as error:
            if not found.done:
                raise
            kept = ", ".join(map(str, found.done))
            raise Interrupted(f"interrupted at seed {seed}; the runs of seeds {kept} are kept") from error
        found.done[seed] = result
        say(f"seed {seed}: {result.verdict}; the results are in {result.out}")
        found.code = max(found.code, code_of(result))
    return found


def code_of(result: "Result") -> int:
    """Return the exit code of a run, and print why it ended early, if it did."""
    from luxloop.scenarios.files.expect import exit_code

    if not result.complete:
        return print_early_end(result, f"the {result.frames} frames until then are in {result.out}, marked incomplete")
    return exit_code(result.verdict)

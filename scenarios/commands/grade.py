"""`luxloop grade`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.scenarios.commands.arguments import DEFAULT_STEP_TIMEOUT_S, AsJson, Full, StepTimeout
from luxloop.scenarios.commands.grade_files import BoxFiles, grade_files
from luxloop.scenarios.commands.option_groups import given, grouped

if TYPE_CHECKING:
    from luxloop.scenarios.result import Result

NO_FILES = BoxFiles()


@grouped
def grade(
    run: Annotated[
        Path | None, typer.Argument(metavar="RUN", help="A folder that `luxloop run` or `luxloop import` wrote.")
    ] = None,
    tracks: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File of tracks that another program made from the run's scans.")
    ] = None,
    files: BoxFiles = NO_FILES,
    tracker: Annotated[
        str | None,
        typer.Option(metavar="MODULE:NAME", help="A tracker to run on the scans, as for luxloop run."),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(metavar="SCENARIO", help="Scenario whose [grading] and [expect] replace the run's."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; if left out, they are only printed.")] = None,
    as_json: AsJson = False,
    full: Full = False,
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S,
) -> None:
    """Grade a run again without simulation, a recording with true poses, or any tracks against any truth in files."""
    from luxloop.scenarios import interface
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.files.expect import exit_code

    if tracks and tracker:
        raise InputError("--tracks and --tracker are both given; give one, or none for the run's own tracks")
    either = "give either RUN, or --truth FILE and --tracks FILE"
    if run is None:
        for name, value in {"--tracker": tracker, "--scenario": scenario}.items():
            if value is not None:
                raise InputError(f"{name} needs RUN; {either}")
        grade_files(tracks, files, out, as_json)
        return
    for name in given(files):
        raise InputError(f"{name} cannot be given with RUN; {either}")
    result = interface.grade(
        run, tracks=tracks, tracker=tracker, scenario=scenario, out=out, step_timeout_s=step_timeout
    )
    _print(result, run, as_json, full)
    raise typer.Exit(exit_code(result.verdict))


def _print(result: "Result", run: Path, as_json: bool, full: bool) -> None:
    """Print the document, the first screen or the full report."""
    import json

    from luxloop.scenarios.report import first_screen, text
    from luxloop.scenarios.run import run_folder

    checks, out = result.checks, result.out
    if as_json:
        print(json.dumps({**run_folder.document(result, checks), "out": out and str(out)}, allow_nan=False))
    elif full:
        text.show(text.report(result, checks))
        print(f"Results are in {out}" if out else "Nothing was written; to keep it, give --out")
    elif out:
        first_screen.show_folder(result, checks, out, recorded=False)
    else:
        keep = {f"luxloop grade {run} --out DIR": "nothing was written; this keeps it"}
        first_screen.show(result, checks, keep, "--full prints the whole report")

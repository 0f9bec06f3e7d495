"""Commands that run studies: `luxloop sweep`, `search` and `thresholds`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import (
    AsJson,
    Figures,
    Quiet,
    RetryErrors,
    Scheduler,
    StudyName,
    Tracker,
    Workers,
    require,
    worker_count,
)
from luxloop.scenarios.commands.error_messages import print_failed_runs
from luxloop.scenarios.exit_codes import INTERNAL_ERROR

if TYPE_CHECKING:
    from luxloop.scenarios.study.study_file import Study
    from luxloop.scenarios.study.sweep_runs import Sweep


def sweep(
    study: StudyName,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; sweeps/STUDY if left out.")] = None,
    tracker: Tracker = None,
    keep: Annotated[
        str | None, typer.Option(metavar="URL", help="Folder or fsspec URL that receives every run's folder.")
    ] = None,
    parts: Annotated[
        str | None, typer.Option(metavar="URL", hidden=True, help="No longer needed, and ignored.")
    ] = None,
    seeds: Annotated[
        str | None, typer.Option(metavar="FIRST-LAST", help="Seeds instead of those of the study, e.g. 1-6.")
    ] = None,
    retry_errors: RetryErrors = False,
    figures: Figures = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Run a study: all combinations of its parameters with all seeds. A second start continues an interrupted one.

    The first line of the output is the number of runs. Exit with 1 if a run ended with an error, with 70 if by a
    defect of luxloop. Failed expectations are results of a study, not errors.
    """
    require("sweep", "sweeps")
    import json
    import sys

    from luxloop.scenarios.document.figure import parse_formats
    from luxloop.scenarios.run.device import SHIPPED, absolute
    from luxloop.scenarios.run.progress import hidden
    from luxloop.scenarios.study.study_file import Study, find
    from luxloop.scenarios.study.study_page import report
    from luxloop.scenarios.study.sweep_runs import sweep as run_study

    formats = parse_formats(figures)
    path, count = find(study), worker_count(workers, scheduler)
    out = out or Path("sweeps") / path.stem
    loaded = Study.load(path) if seeds is None else Study.load(path).with_seeds(seeds)
    if parts is not None:
        print_text("luxloop: --parts is no longer needed: all rows are in runs.sqlite; leave it out", file=sys.stderr)
    if not (as_json or quiet):
        print_text(_announcement(loaded), flush=True)
    with hidden(quiet):
        done = run_study(loaded, absolute(tracker or SHIPPED), out, count, scheduler, keep, retry_errors)
    report(done, out, formats)
    if as_json:
        print_text(json.dumps(document(done, out), allow_nan=False))
    elif not quiet:
        print_text(_summary(done, out))
    raise typer.Exit(_exit_code(done))


def _exit_code(done: "Sweep") -> int:
    """Return the exit code; a line names the internal errors of runs, if there are some."""
    errors = [str(error) for error in done.rows.loc[done.rows["status"] == "error", "error"]]
    internal = [error for error in errors if error.startswith(INTERNAL_ERROR)]
    return print_failed_runs(internal) if internal else int(bool(errors))


def _announcement(study: "Study") -> str:
    """Return the first line of the output, which names the number of runs before any of them begins."""
    from luxloop.scenarios.study.design import combinations

    count, seeds = len(combinations(study)), len(study.seed_list)
    return f"{count * seeds} runs in {study.path.stem} (combinations: {count}, seeds: {seeds})"


def document(done: "Sweep", out: Path) -> dict[str, Any]:
    """Return the JSON document of `--json`."""
    from luxloop.scenarios.study.row_store import TABLE
    from luxloop.scenarios.study.study_page import REPORT, answer

    return {
        "study": done.study.path.stem,
        "answer": answer(done),
        "runs": done.count,
        "taken_up": done.taken_up,
        "why": {str(reason): int(count) for reason, count in done.rows["why"].value_counts().sort_index().items()},
        "status": {str(name): int(count) for name, count in done.rows["status"].value_counts().sort_index().items()},
        "errors": sorted(set(done.rows.loc[done.rows["status"] == "error", "error"])),
        "out": str(out),
        "rows": str(out / TABLE),
        "report": str(out / REPORT),
    }


WORDS = {
    "passed": "passed", "failed": "broke an expectation", "incomplete": "ended early", "error": "without a result",
}  # fmt: skip
"""Text of each status in the summary."""


def _summary(done: "Sweep", out: Path) -> str:
    """Return the summary that is printed without `--json`."""
    shown = document(done, out)
    counts = ", ".join(f"{count} {WORDS[name]}" for name, count in shown["status"].items())
    earlier = f" {done.taken_up} of them were there from an earlier start." if done.taken_up else ""
    again = [f"{count} {reason}" for reason, count in shown["why"].items() if reason.startswith("run again")]
    lines = [
        shown["answer"],
        f"{done.count} runs: {counts}.{earlier}",
        *again,
        *(f"error: {error}" for error in shown["errors"][:5]),
    ]
    return "\n".join([*lines, f"A row per run is in {shown['rows']}, curves in {shown['report']}"])


def search(
    study: StudyName,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; searches/STUDY if left out.")] = None,
    tracker: Tracker = None,
    retry_errors: RetryErrors = False,
) -> None:
    """Search for the smallest disturbance that breaks the tracker, and reduce it to a minimal scenario file.

    Exit with 1 if one is found, with 70 if a run ended by a defect of luxloop. A second start reuses earlier runs.
    """
    require("search", "search")
    from luxloop.scenarios.run.device import SHIPPED, absolute
    from luxloop.scenarios.search.adversary import search as find_failure
    from luxloop.scenarios.search.evaluator import TrialOptions
    from luxloop.scenarios.study.study_file import Study, find

    path, count = find(study), worker_count(workers, scheduler)
    out = out or Path("searches") / path.stem
    device = absolute(tracker or SHIPPED)
    defects: list[str] = []
    options = TrialOptions(count, scheduler, retry_errors, defects.append)
    found = find_failure(Study.load(path), device, out, _print_now, options)
    if found is not None:
        print_text(f"{found.file} fails: {found.what}")
        print_text(f"To run it: luxloop run {found.file}; to view it: luxloop view {found.result.out}")
    raise typer.Exit(print_failed_runs(defects) if defects else int(found is not None))


def _print_now(line: str) -> None:
    print_text(line, flush=True)


def thresholds(
    study: StudyName,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; thresholds/STUDY if left out.")] = None,
    tracker: Tracker = None,
    retry_errors: RetryErrors = False,
    figures: Figures = None,
    as_json: AsJson = False,
) -> None:
    """Estimate the value of a parameter at which a share of runs keeps a metric, with few runs placed adaptively.

    A second start reuses the runs of an earlier one.
    """
    require("thresholds", "sweeps")
    import json

    from luxloop.scenarios.document.figure import parse_formats
    from luxloop.scenarios.report import text
    from luxloop.scenarios.run.device import SHIPPED, absolute
    from luxloop.scenarios.run.progress import hidden
    from luxloop.scenarios.search import thresholds
    from luxloop.scenarios.search.evaluator import TrialOptions
    from luxloop.scenarios.search.thresholds import thresholds as estimate
    from luxloop.scenarios.study.study_file import Study, find

    formats = parse_formats(figures)
    path, count = find(study), worker_count(workers, scheduler)
    out, loaded = out or Path("thresholds") / path.stem, Study.load(path)
    notify = (lambda _: None) if as_json else print
    defects: list[str] = []
    options = TrialOptions(count, scheduler, retry_errors, defects.append)
    with hidden(as_json):
        found = estimate(loaded, absolute(tracker or SHIPPED), out, notify, options)
    thresholds.write(loaded, found, out, formats)
    if as_json:
        print_text(json.dumps({**thresholds.document(loaded, found), "out": str(out)}, allow_nan=False))
    else:
        text.show(thresholds.report(loaded, found))
        print_text(f"Estimates, runs and figure are in {out}")
    raise typer.Exit(print_failed_runs(defects) if defects else 0)

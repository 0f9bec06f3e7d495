"""`luxloop sweep` on the command line. What takes long to import is imported where it is needed."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenarios.commands.arguments import AsJson, Scheduler, StudyName, Tracker, Workers, worker_count

if TYPE_CHECKING:
    from scenarios.study.sweep_runs import Sweep


def sweep(
    study: StudyName,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results, else sweeps/STUDY.")] = None,
    tracker: Tracker = None,
    keep: Annotated[
        str | None, typer.Option(metavar="URL", help="Folder or fsspec URL that gets every run's folder, too.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run a study, all combinations with all seeds; started again, it does what is not done yet.

    Exit with 1 if a run ended with an error. That expectations of its scenario fail is what a study is to find out.
    """
    import json

    from scenarios.run.device import SHIPPED
    from scenarios.study.study_file import Study, find
    from scenarios.study.study_page import report
    from scenarios.study.sweep_runs import sweep as carry_out

    path, count = find(study), worker_count(workers, scheduler)
    out = out or Path("sweeps") / path.stem
    done = carry_out(Study.load(path), tracker or SHIPPED, out, count, scheduler, keep)
    report(done, out)
    if as_json:
        print(json.dumps(document(done, out), allow_nan=False))
    else:
        print(_told(done, out))
    raise typer.Exit(1 if (done.rows["status"] == "error").any() else 0)


def document(done: "Sweep", out: Path) -> dict[str, Any]:
    """Return what `--json` prints."""
    from scenarios.study.row_store import RUNS
    from scenarios.study.study_page import REPORT

    return {
        "study": done.study.path.stem,
        "runs": done.count,
        "taken_up": done.taken_up,
        "status": {str(name): int(count) for name, count in done.rows["status"].value_counts().sort_index().items()},
        "errors": sorted(set(done.rows.loc[done.rows["status"] == "error", "error"])),
        "out": str(out),
        "rows": str(out / RUNS),
        "report": str(out / REPORT),
    }


WORDS = {
    "passed": "passed", "failed": "broke an expectation", "incomplete": "ended early", "error": "without a result",
}  # fmt: skip
"""For a status."""


def _told(done: "Sweep", out: Path) -> str:
    """Return what a person reads."""
    told = document(done, out)
    counts = ", ".join(f"{count} {WORDS[name]}" for name, count in told["status"].items())
    earlier = f" {done.taken_up} of them were there from an earlier start." if done.taken_up else ""
    lines = [f"{done.count} runs: {counts}.{earlier}", *(f"error: {error}" for error in told["errors"][:5])]
    return "\n".join([*lines, f"A row per run is in {told['rows']}, curves in {told['report']}"])

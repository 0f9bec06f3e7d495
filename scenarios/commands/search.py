"""`luxloop search`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import RetryErrors, Scheduler, StudyName, Tracker, Workers, worker_count
from luxloop.scenarios.commands.extras import require
from luxloop.scenarios.commands.internal_error import print_failed_runs


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
    from luxloop.scenarios.study.study_file import Study, find

    path, count = find(study), worker_count(workers, scheduler)
    out = out or Path("searches") / path.stem
    device = absolute(tracker or SHIPPED)
    defects: list[str] = []
    found = find_failure(
        Study.load(path), device, out, _print_now, count, scheduler, retry_errors=retry_errors,
        report_defect=defects.append,
    )  # fmt: skip
    if found is not None:
        print(f"{found.file} fails: {found.what}")
        print(f"To run it: luxloop run {found.file}; to view it: luxloop view {found.result.out}")
    raise typer.Exit(print_failed_runs(defects) if defects else int(found is not None))


def _print_now(line: str) -> None:
    print(line, flush=True)

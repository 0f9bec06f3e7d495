"""`luxloop search`."""

from pathlib import Path
from typing import Annotated

import typer

from scenarios.commands.arguments import Scheduler, StudyName, Tracker, Workers, worker_count


def search(
    study: StudyName,
    workers: Workers = None,
    scheduler: Scheduler = None,
    out: Annotated[Path | None, typer.Option(help="Folder of what is found, else searches/STUDY.")] = None,
    tracker: Tracker = None,
) -> None:
    """Look for the smallest disturbance that breaks the tracker, and shrink it to a scenario file.

    Exit with 1 if one is found. A second start repeats no run of an earlier one.
    """
    from scenarios.report import text
    from scenarios.run.device import SHIPPED
    from scenarios.search.adversary import search as look
    from scenarios.study.study_file import Study, find

    path, count = find(study), worker_count(workers, scheduler)
    out = out or Path("searches") / path.stem
    found = look(Study.load(path), tracker or SHIPPED, out, _tell, count, scheduler)
    if found is None:
        return
    text.show(found.outcome.report)
    print(f"{found.file} fails: {found.what}")
    print(f"To run it: luxloop run {found.file}; to watch it: luxloop view {found.outcome.out}")
    raise typer.Exit(1)


def _tell(line: str) -> None:
    print(line, flush=True)

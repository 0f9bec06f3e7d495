"""`luxloop search`."""

from pathlib import Path
from typing import Annotated

import typer


def search(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="A study file with a [search] table.")],
    out: Annotated[Path | None, typer.Option(help="Folder of what is found, else searches/STUDY.")] = None,
    tracker: Annotated[
        str | None, typer.Option(metavar="MODULE:NAME", help="Another device under test, see scenarios/device.py.")
    ] = None,
) -> None:
    """Look for the smallest disturbance that breaks the tracker, and shrink it to a scenario file.

    Exit with 1 if one is found. A second start repeats no run of an earlier one.
    """
    from scenarios import report
    from scenarios.device import SHIPPED
    from scenarios.search.search import search as look
    from scenarios.study.study import Study

    found = look(Study.load(study), tracker or SHIPPED, out or Path("searches") / study.stem, _tell)
    if found is None:
        return
    report.show(found.outcome.report)
    print(f"{found.file} fails: {found.what}")
    print(f"To run it: luxloop run {found.file}; to watch it: luxloop view {found.outcome.out}")
    raise typer.Exit(1)


def _tell(line: str) -> None:
    print(line, flush=True)

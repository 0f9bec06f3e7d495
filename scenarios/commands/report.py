"""`luxloop report`."""

from pathlib import Path
from typing import Annotated

import typer


def report(
    folder: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run, or a folder of many runs.")],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="The page to write; RUN.html if left out.")] = None,
) -> None:
    """Write the report of one run or many as a single HTML file."""
    from scenarios.report.html import pages
    from scenarios.report.html.run_page import run_page
    from scenarios.report.html.suite_page import find_runs, suite_page
    from scenarios.run import run_folder

    is_run = (folder / run_folder.RESULT).is_file()
    page = run_page(folder) if is_run else suite_page(find_runs(folder))
    out = out or folder.resolve().with_name(f"{folder.resolve().name}.html")
    pages.write(out, page)
    print(f"The report is in {out}")

"""`luxloop view` and `luxloop report`: runs for the eye."""

from pathlib import Path
from typing import Annotated

import typer

from scenarios.commands.arguments import RunFolder


def view(
    run: RunFolder,
    frame: Annotated[int | None, typer.Option(help="Open it there, instead of at the worst frame.")] = None,
    web: Annotated[bool, typer.Option("--web", help="In a browser, which always opens at the end.")] = False,
) -> None:
    """Open a run's recording in the rerun viewer, at the worst frame of what failed."""
    from scenarios.recording import viewer
    from scenarios.report.html.reported_run import Run
    from scenarios.run import run_folder

    recording = run_folder.recording(run)
    shown = Run.read(run)
    look = viewer.moment(shown.result, shown.unmet, frame)
    if look:
        print(f"{'Go to' if web else 'Opens at'} {look}")
    raise typer.Exit(viewer.show(recording, look.time_s if look else None, web=web))


def report(
    folder: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run, or one with many runs in it.")],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="The page, else RUN.html.")] = None,
) -> None:
    """Write the report of a run, or of many, as one HTML file."""
    from scenarios.report.html import pages
    from scenarios.report.html.run_page import run_page
    from scenarios.report.html.suite_page import find_runs, suite_page
    from scenarios.run import run_folder

    is_run = (folder / run_folder.RESULT).is_file()
    page = run_page(folder) if is_run else suite_page(find_runs(folder))
    out = out or folder.resolve().with_name(f"{folder.resolve().name}.html")
    pages.write(out, page)
    print(f"The report is in {out}")

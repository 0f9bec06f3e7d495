"""`luxloop view`."""

from pathlib import Path
from typing import Annotated

import typer


def view(
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="A folder that `luxloop run` wrote, or a recording of `luxloop report`."),
    ],
    frame: Annotated[int | None, typer.Option(help="Start at this frame instead of the worst one.")] = None,
    web: Annotated[bool, typer.Option("--web", help="Open in a browser (starts at the last frame).")] = False,
    analytics: Annotated[
        bool,
        typer.Option("--analytics", help="Let the viewer send statistics of its use, if its own settings allow that."),
    ] = False,
) -> None:
    """Open a run's recording in the rerun viewer, at the worst frame of a failed expectation."""
    from luxloop.scenarios.recording import viewer
    from luxloop.scenarios.report.html.reported_run import ReportedRun
    from luxloop.scenarios.run import run_folder

    recording = run if run.suffix == ".rrd" and run.is_file() else run_folder.recording(run)
    if not web:
        viewer.require_display(run)
    if recording == run:
        raise typer.Exit(viewer.show(recording, None, web=web, analytics=analytics))
    shown = ReportedRun.read(run)
    start = viewer.frame_to_show(shown.result, shown.unmet, frame)
    if start:
        print(f"{'Go to' if web else 'Opens at'} {start}")
    raise typer.Exit(viewer.show(recording, start.time_s if start else None, web=web, analytics=analytics))

"""`luxloop view`."""

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
    from scenarios.report.html.reported_run import ReportedRun
    from scenarios.run import run_folder

    recording = run_folder.recording(run)
    shown = ReportedRun.read(run)
    look = viewer.frame_to_show(shown.result, shown.unmet, frame)
    if look:
        print(f"{'Go to' if web else 'Opens at'} {look}")
    raise typer.Exit(viewer.show(recording, look.time_s if look else None, web=web))

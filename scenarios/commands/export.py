"""`luxloop export`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import RunFolder
from luxloop.scenarios.commands.extras import require_of


def export(
    run: RunFolder,
    folder_format: Annotated[str, typer.Option("--format", metavar="FORMAT", help="One of {export}.")],
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="The folder to write; it must not exist.")],
) -> None:
    """Write a run's recorded scans, ground truth and tracks as a folder in the format of other programs."""
    from luxloop.scenarios.exchange.exported_run import write_folder
    from luxloop.scenarios.files.format_option import format_named
    from luxloop.scenarios.offline.recorded_run import RecordedRun
    from luxloop.scenarios.report.cells import counted

    chosen = format_named("--format", folder_format, "export")
    require_of("export", chosen)
    recorded = RecordedRun.open(run)
    write_folder(recorded, out, chosen)
    print(f"{counted(recorded.result.frames, 'frame is', 'frames are')} in {out}")

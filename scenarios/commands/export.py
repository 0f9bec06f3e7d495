"""`luxloop export`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scenarios.commands.arguments import RunFolder

if TYPE_CHECKING:
    from scenarios.exchange.exported_run import Exporter


def export(
    run: RunFolder,
    folder_format: Annotated[str, typer.Option("--format", metavar="FORMAT", help="kitti or nuscenes.")],
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="The folder to write; it must not exist.")],
) -> None:
    """Write a run's recorded scans, ground truth and tracks as a folder in the format of a public data set."""
    from scenarios.errors import InputError
    from scenarios.exchange import kitti_export, nuscenes_export
    from scenarios.exchange.exported_run import write_folder
    from scenarios.offline.recorded_run import RecordedRun

    exporters: dict[str, Exporter] = {"kitti": kitti_export.export, "nuscenes": nuscenes_export.export}
    if folder_format not in exporters:
        raise InputError(f"--format {folder_format}: is none of {', '.join(exporters)}")
    recorded = RecordedRun.open(run)
    write_folder(recorded, out, exporters[folder_format])
    print(f"{recorded.result.frames} frames are in {out}")

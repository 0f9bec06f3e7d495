"""`luxloop export`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.scenarios.commands.arguments import RunFolder
from luxloop.scenarios.commands.extras import require

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.exported_run import Exporter

FORMATS = ("kitti", "nuscenes", "t4", "osi", "lux")


def export(
    run: RunFolder,
    folder_format: Annotated[str, typer.Option("--format", metavar="FORMAT", help=f"One of {', '.join(FORMATS)}.")],
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="The folder to write; it must not exist.")],
) -> None:
    """Write a run's recorded scans, ground truth and tracks as a folder in the format of other programs."""
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.exchange.exported_run import write_folder
    from luxloop.scenarios.offline.recorded_run import RecordedRun
    from luxloop.scenarios.report.cells import counted

    if folder_format not in FORMATS:
        raise InputError(f"--format {folder_format}: is none of {', '.join(FORMATS)}")
    exporter = _exporter(folder_format)
    recorded = RecordedRun.open(run)
    write_folder(recorded, out, exporter)
    print(f"{counted(recorded.result.frames, 'frame is', 'frames are')} in {out}")


def _exporter(folder_format: str) -> "Exporter":
    """Return the writer of a format, which may need packages of an extra."""
    if folder_format == "osi":
        require("export", "osi")
        from luxloop.scenarios.exchange.osi import trace_export

        return trace_export.export
    from luxloop.scenarios.exchange import kitti_export, lux_export, nuscenes_export, t4_export

    exporters = {"kitti": kitti_export, "nuscenes": nuscenes_export, "t4": t4_export, "lux": lux_export}
    found: Exporter = exporters[folder_format].export
    return found

"""`luxloop mcap`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import RunFolder
from luxloop.scenarios.commands.extras import require


def mcap(
    run: RunFolder,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The .mcap file to write.")],
) -> None:
    """Write a run's recorded scans, ground truth and tracks as MCAP, for tools of ROS 2 and Foxglove."""
    require("mcap", "mcap")
    from luxloop.scenarios.offline.mcap.export import export
    from luxloop.scenarios.offline.recorded_run import RecordedRun

    frames = export(RecordedRun.open(run), file)
    print(f"{frames} frames are in {file}")

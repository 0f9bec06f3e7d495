"""Format `t4`: T4 data sets of TIER IV, which have the tables of nuScenes with extensions."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from luxloop.scenarios.offline.recorded_scans import RecordedRun


def export(run: "RecordedRun", folder: Path) -> None:
    """Write a run as one scene. See `RunFormat`."""
    from luxloop.scenarios.exchange.t4 import t4_export

    t4_export.export(run, folder)

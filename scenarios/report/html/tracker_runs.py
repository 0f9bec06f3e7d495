"""Runs of several trackers on the same drive."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.run.device import short_name

SAME_M = 1e-6
"""Tolerance of positions in the truth of two runs [m]: traffic differs by less on two types of CPU."""
POSITION = ["frame", "actor_id", "x_world_m", "y_world_m"]


def same_drive(folders: Sequence[Path]) -> bool:
    """Return True for several runs of one scenario and seed.

    Raises
    ------
    OutputError
        A folder has a damaged run.
    """
    drives = {(result.scenario, result.seed) for result in map(run_folder.read, folders)}
    return len(folders) > 1 and len(drives) == 1


def read_trackers(folders: Sequence[Path]) -> dict[str, ReportedRun]:
    """Read runs of one drive, by the names of their trackers.

    Raises
    ------
    InputError
        The traffic of two runs differs.
    OutputError
        A folder has no run.
    """
    runs = [ReportedRun.read(folder) for folder in folders]
    for run in runs[1:]:
        if not _same_traffic(runs[0].result, run.result):
            raise InputError(
                f"{run.folder}: its traffic differs from that of {runs[0].folder}; give runs of the same drive, "
                "or report each of them alone"
            )
    return dict(zip(_names(runs), runs, strict=True))


def _names(runs: Sequence[ReportedRun]) -> list[str]:
    """Return the names of the trackers with their settings, or of the folders if these are equal."""
    names = [" ".join([short_name(run.result.config["device"]), *run.result.config.get("set", [])]) for run in runs]
    if len(set(names)) == len(names):
        return names
    folders = [run.folder.resolve() for run in runs]
    short = [folder.name for folder in folders]
    return short if len(set(short)) == len(short) else [str(folder) for folder in folders]


def _same_traffic(one: Result, other: Result) -> bool:
    """Compare the truth of the frames that both runs have."""
    frames = min(one.frames, other.frames)
    truths = (result.tables["truth"] for result in (one, other))
    first, second = (truth[truth["frame"] < frames][POSITION].to_numpy() for truth in truths)
    return first.shape == second.shape and np.allclose(first, second, rtol=0.0, atol=SAME_M)

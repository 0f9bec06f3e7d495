"""Arguments and options that several commands have."""

import os
from pathlib import Path
from typing import Annotated

import typer

ScenarioName = Annotated[
    str, typer.Argument(metavar="SCENARIO", help="A name from `luxloop list`, or the path of a .toml file.")
]
RunFolder = Annotated[Path, typer.Argument(metavar="RUN", help="A folder that `luxloop run` wrote.")]
Seed = Annotated[int | None, typer.Option(help="Seed of traffic and noise, instead of the scenario's.")]
Duration = Annotated[float | None, typer.Option(help="Simulated seconds, instead of the scenario's.")]
StudyName = Annotated[
    str, typer.Argument(metavar="STUDY", help="A name from `luxloop list --studies`, or the path of a .toml file.")
]
Tracker = Annotated[
    str | None, typer.Option(metavar="MODULE:NAME", help="Another device under test, see scenarios/run/device.py.")
]
Workers = Annotated[int | None, typer.Option(min=1, help="Processes of this computer, else one for each of its cores.")]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="host:port of a Dask scheduler, whose workers do it instead.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, and nothing else.")]


def overrides(seed: int | None, duration: float | None) -> dict[str, int | float]:
    """Keys of the scenario file that the command line replaces."""
    return {key: value for key, value in {"seed": seed, "duration_s": duration}.items() if value is not None}


def worker_count(workers: int | None, scheduler: str | None) -> int:
    """Return how many processes of this computer are to work, unless a scheduler's do.

    Raises
    ------
    StudyError
        Both are given.
    """
    from scenarios.errors import StudyError

    if workers and scheduler:
        raise StudyError("--workers and --scheduler are both given; the scheduler has workers of its own, give one")
    return workers or _cores()


def _cores() -> int:
    """Return how many cores this process may use: fewer than there are in a container."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

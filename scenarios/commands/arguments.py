"""Arguments and options that several commands have."""

from pathlib import Path
from typing import Annotated

import typer

ScenarioName = Annotated[
    str, typer.Argument(metavar="SCENARIO", help="A name from `luxloop list`, or the path of a .toml file.")
]
RunFolder = Annotated[Path, typer.Argument(metavar="RUN", help="A folder that `luxloop run` wrote.")]
Seed = Annotated[int | None, typer.Option(help="Seed of traffic and noise, instead of the scenario's.")]
Duration = Annotated[float | None, typer.Option(help="Simulated seconds, instead of the scenario's.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, and nothing else.")]


def overrides(seed: int | None, duration: float | None) -> dict[str, int | float]:
    """Keys of the scenario file that the command line replaces."""
    return {key: value for key, value in {"seed": seed, "duration_s": duration}.items() if value is not None}

"""Arguments, options and groups of options that commands share, and the optional packages that commands need."""

import math
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from functools import wraps
from importlib.util import find_spec
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any

import typer

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.interface import STEP_TIMEOUT_S, cores
from luxloop.sim.optional_packages import install_command


def _scenarios(incomplete: str) -> list[str]:
    """Complete the name of a shipped scenario."""
    from luxloop.scenarios.files import shipped

    return [name for name in shipped.paths() if name.startswith(incomplete)]


def _studies(incomplete: str) -> list[str]:
    """Complete the name of a shipped study."""
    from luxloop.scenarios.files import shipped

    return [name for name in shipped.studies() if name.startswith(incomplete)]


def finite(value: float | None) -> float | None:
    """Return the number of an option; the callback of every option that takes one.

    Raises
    ------
    typer.BadParameter
        It is infinite, or no number.
    """
    if value is not None and not math.isfinite(value):
        raise typer.BadParameter(f"{value:g}: should be a finite number")
    return value


ScenarioName = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A name from `luxloop list`, or the path of a .toml file.",
        autocompletion=_scenarios,
    ),
]
RunFolder = Annotated[Path, typer.Argument(metavar="RUN", help="A folder that `luxloop run` wrote.")]
Seed = Annotated[int | None, typer.Option(help="Seed of traffic and noise, instead of the scenario's.")]
Duration = Annotated[float | None, typer.Option(callback=finite, help="Simulated seconds, instead of the scenario's.")]
StudyName = Annotated[
    str,
    typer.Argument(
        metavar="STUDY",
        help="A name from `luxloop list --studies`, or the path of a .toml file.",
        autocompletion=_studies,
    ),
]
Tracker = Annotated[
    str | None,
    typer.Option(
        metavar="MODULE:NAME",
        help="The tracker: MODULE:NAME, FILE.py:NAME, process:COMMAND or the name of a plug-in; else the shipped one.",
    ),
]
StepTimeout = Annotated[
    float, typer.Option(metavar="SECONDS", min=0.001, callback=finite, help="Time limit of one step of the tracker.")
]
Workers = Annotated[int | None, typer.Option(min=1, help="Processes of this computer; one per core if left out.")]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="host:port of a Dask scheduler whose workers carry out the runs.")
]
DEFAULT_STEP_TIMEOUT_S = STEP_TIMEOUT_S
RetryErrors = Annotated[bool, typer.Option("--retry-errors", help="Run again what ended with an error.")]
Figures = Annotated[
    str | None, typer.Option(metavar="FORMAT,...", help="Also write the figures as files: svg, pdf, png.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
Full = Annotated[
    bool, typer.Option("--full", help="Print the whole report, as in report.txt, instead of the first screen.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, and nothing else.")]


def overrides(seed: int | None, duration: float | None) -> dict[str, int | float]:
    """Return the keys of the scenario file that the command line replaces."""
    return {key: value for key, value in {"seed": seed, "duration_s": duration}.items() if value is not None}


def worker_count(workers: int | None, scheduler: str | None) -> int:
    """Return the number of local worker processes; a scheduler has workers of its own instead.

    Raises
    ------
    StudyError
        Both are given.
    """
    from luxloop.scenarios.errors import StudyError

    if workers and scheduler:
        raise StudyError("--workers and --scheduler are both given; give one, a scheduler has its own workers")
    return workers or cores()


EXTRAS = {
    "sweeps": ("dask", "distributed", "fsspec"),
    "search": ("dask", "distributed", "fsspec", "optuna", "tomli_w"),
    "mcap": ("mcap", "mcap_ros2"),
    "osi": ("betterosi", "mcap"),
    "recordings": ("rosbags", "mcap", "mcap_ros2"),
    "league": ("stonesoup", "norfair"),
}
"""Modules by extra, as in `pyproject.toml`. `commonroad` is checked where it is imported, in `sim.commonroad`; `tests`
and `docs` serve other programs than luxloop."""


def require(command: str, extra: str) -> None:
    """Check that the packages of an extra are installed, before a command starts.

    Raises
    ------
    InputError
        A package is missing.
    """
    for package in EXTRAS[extra]:
        if find_spec(package) is None:
            missing = f"luxloop {command} needs {package}, which is not installed"
            raise InputError(f"{missing}: {install_command(extra)}")


def require_of(command: str, plugin: object) -> None:
    """Check that the packages of a plug-in of luxloop are installed; its `EXTRA` names their extra.

    Raises
    ------
    InputError
        A package is missing.
    """
    if extra := getattr(plugin, "EXTRA", ""):
        require(command, extra)


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that has the fields of its dataclass parameters as options."""
    parameters = signature(command).parameters.values()
    groups: dict[str, Any] = {one.name: one.annotation for one in parameters if is_dataclass(one.annotation)}
    options = [option for one in parameters for option in _options(one)]

    @wraps(command)
    def parsed(**given: Any) -> None:
        records = {
            name: group(**{field.name: given.pop(field.name) for field in fields(group)})
            for name, group in groups.items()
        }
        command(**given, **records)

    parsed.__signature__ = Signature(options)  # type: ignore[attr-defined]  # typer reads it, and the annotations
    parsed.__annotations__ = {one.name: one.annotation for one in options}
    return parsed


def given(record: Any) -> list[str]:
    """Return the options of a group that differ from their defaults, as they are typed."""
    names = [field.name for field in fields(record) if getattr(record, field.name) != field.default]
    return [f"--{name.replace('_', '-')}" for name in names]


def _options(parameter: Parameter) -> Iterator[Parameter]:
    if not is_dataclass(parameter.annotation):
        yield parameter.replace(kind=Parameter.KEYWORD_ONLY)
        return
    for field in fields(parameter.annotation):
        yield Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)

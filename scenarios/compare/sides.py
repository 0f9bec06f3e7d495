"""Side of a comparison: a folder of runs, a single run, a baseline file, or results."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.compare.digest import Key, RunDigest, digest, read_run
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder


@dataclass(frozen=True, slots=True)
class Side:
    """Runs by scenario and seed."""

    path: Path
    """Folder or file; for results, the name of the side."""
    runs: dict[Key, RunDigest]
    unfinished: list[str]
    """Names of temporary folders of unfinished runs, which are left out."""


def of(runs: str | Path | Result | Iterable[str | Path | Result], name: str) -> Side:
    """Return a side: a folder or file, a result, or several run folders or results, which `name` names in messages.

    Raises
    ------
    OutputError
        As for `read`.
    """
    if isinstance(runs, str | Path):
        return read(Path(runs))
    every = [runs] if isinstance(runs, Result) else runs
    return _side(Path(name), [_digest(run) for run in every], [])


def _digest(run: str | Path | Result) -> tuple[RunDigest, Path]:
    if isinstance(run, Result):
        return digest(run), run.out or Path("in memory")
    return read_run(Path(run)), Path(run)


def read(path: Path) -> Side:
    """Read BASE or HEAD.

    Raises
    ------
    OutputError
        `path` has no run, a run is damaged, or two runs have the same scenario and seed.
    """
    return read_runs(path) if path.is_dir() else _side(path, [(run, path) for run in baseline_file.read(path)], [])


def read_runs(folder: Path) -> Side:
    """Read all runs in a folder and its subfolders, or a single run folder.

    Raises
    ------
    OutputError
        As for `read`.
    """
    if not folder.is_dir():
        raise OutputError(f"{folder}: no such folder; give a folder with runs of luxloop run or pytest")
    unfinished = sorted(path.name for path in folder.rglob(".*.partial"))
    return _side(folder, [(read_run(run), run) for run in run_folder.found_in(folder)], unfinished)


def _side(path: Path, runs: list[tuple[RunDigest, Path]], unfinished: list[str]) -> Side:
    """Sort the runs, each with the path it was read from, by scenario and seed."""
    if not runs:
        raise OutputError(f"{path}: no run in it; give a folder with runs of luxloop run or pytest")
    by_key: dict[Key, RunDigest] = {}
    places: dict[Key, Path] = {}
    for run, place in sorted(runs, key=lambda entry: entry[0].key):
        if run.key in by_key:
            raise OutputError(f"{path}: two runs of {run.key}, {places[run.key]} and {place}; keep one of them")
        by_key[run.key], places[run.key] = run, place
    return Side(path, by_key, unfinished)

"""The folder a run leaves behind. It appears as a whole or not at all; a run that ended early says so in it.

- `result.json`: metrics, verdict, trace hash, effective config, versions
- `report.txt`: what was printed
- `tables/*.parquet`: per-frame tables
- `recording.rrd`: for `luxloop view`, unless switched off
"""

import json
import os
import platform
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd

from scenarios.errors import OutputError
from scenarios.expect import Check, verdict
from scenarios.result import Metric, Result

RESULT = "result.json"
REPORT = "report.txt"
RECORDING = "recording.rrd"
TABLES = "tables"


@contextmanager
def create(out: Path) -> Iterator[Path]:
    """Give a temporary folder beside `out` to write into; it becomes `out` at the end, and vanishes on any error.

    An earlier run at `out` is replaced. Folders above `out` are made where missing.

    Raises
    ------
    OutputError
        `out` cannot be written, or is something else than an earlier run.
    """
    out = Path(os.path.realpath(out))
    temporary = _beside(out, "partial")
    missing: list[Path] = []
    try:
        _refuse_to_replace_what_is_no_run(out)
        _remove_what_killed_runs_left(out)
        missing = [folder for folder in out.parents if not folder.exists()]
        temporary.mkdir(parents=True)
    except OSError as error:
        _remove_empty(missing)
        raise _cannot_write(out, error) from error
    try:
        yield temporary
        _move_into_place(temporary, out)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        _remove_empty(missing)
        raise


def document(result: Result, checks: list[Check]) -> dict[str, Any]:
    """Everything of a result but its tables, for JSON; a metric that does not apply is null, with the reason."""
    return {
        "scenario": result.scenario,
        "seed": result.seed,
        "trace_hash": result.trace_hash,
        "verdict": verdict(checks, result.complete),
        "failed": [check.name for check in checks if not check.passed],
        "complete": result.complete,
        "ended_early": result.ended_early,
        "simulator_failed": result.simulator_failed,
        "frames": result.frames,
        "metrics": {name: _metric(metric) for name, metric in result.metrics.items()},
        "config": result.config,
        "versions": result.versions,
    }


def write(folder: Path, result: Result, checks: list[Check], report: str) -> None:
    """Write all but the recording.

    Raises
    ------
    OutputError
        The disk is full, or the like.
    """
    try:
        text = json.dumps(document(result, checks), indent=2, ensure_ascii=False, allow_nan=False)
        (folder / REPORT).write_text(report, encoding="utf-8")
        (folder / TABLES).mkdir()
        for name, table in result.tables.items():
            table.to_parquet(folder / TABLES / f"{name}.parquet", index=False)
        (folder / RESULT).write_text(text + "\n", encoding="utf-8")  # last: where it is, all is
    except OSError as error:
        raise _cannot_write(folder, error) from error


def read(folder: Path) -> Result:
    """Read a run back.

    Raises
    ------
    OutputError
        The folder holds no run.
    """
    try:
        document = json.loads((folder / RESULT).read_text(encoding="utf-8"))
        return Result(
            scenario=document["scenario"],
            seed=document["seed"],
            trace_hash=document["trace_hash"],
            ended_early=document["ended_early"],
            simulator_failed=document["simulator_failed"],
            frames=document["frames"],
            metrics={name: Metric(**metric) for name, metric in document["metrics"].items()},
            tables={path.stem: pd.read_parquet(path) for path in sorted((folder / TABLES).glob("*.parquet"))},
            config=document["config"],
            versions=document["versions"],
        )
    except (OSError, json.JSONDecodeError, KeyError, TypeError) as error:
        raise _no_run(folder) from error


def recording(folder: Path) -> Path:
    """Path of a run's recording.

    Raises
    ------
    OutputError
        The run has none, or the folder holds no run.
    """
    if not (folder / RESULT).is_file():
        raise _no_run(folder)
    path = folder / RECORDING
    if not path.is_file():
        raise OutputError(f"{folder}: no {RECORDING} in it; run the scenario again without --no-recording")
    return path


def _no_run(folder: Path) -> OutputError:
    return OutputError(f"{folder}: no {RESULT} of a run in it; give a folder that luxloop run wrote")


def _cannot_write(folder: Path, error: OSError) -> OutputError:
    return OutputError(f"{folder}: cannot write there ({error.strerror}); choose another folder with --out")


def _metric(metric: Metric) -> dict[str, Any]:
    """The reason is told only where there is no value."""
    return {key: value for key, value in asdict(metric).items() if key != "reason" or value}


def _refuse_to_replace_what_is_no_run(out: Path) -> None:
    if out.is_dir():
        names = {path.name for path in out.iterdir()}
        if names and not {RESULT} <= names <= {RESULT, REPORT, RECORDING, TABLES}:
            raise OutputError(f"{out}: holds other things than a run; choose a new or an empty folder with --out")
    elif out.exists():
        raise OutputError(f"{out}: is a file; choose another folder with --out")


def _move_into_place(temporary: Path, out: Path) -> None:
    """Swap a folder in; the earlier one is out of the way for the blink of a rename only."""
    if not out.exists():
        temporary.rename(out)
        return
    earlier = _beside(out, "earlier")
    out.rename(earlier)
    try:
        temporary.rename(out)
    except OSError:
        earlier.rename(out)
        raise
    shutil.rmtree(earlier)


def _beside(out: Path, purpose: str) -> Path:
    """Return a name that nothing has yet, and that tells whose it is."""
    return out.with_name(f".{out.name}.{platform.node()}-{os.getpid()}-{secrets.token_hex(4)}.{purpose}")


def _remove_what_killed_runs_left(out: Path) -> None:
    """Remove what nobody will rename any more; an earlier run that was moved away stays while there is no other."""
    purposes = ("partial", "earlier") if out.exists() else ("partial",)
    pattern = re.compile(rf"\.{re.escape(out.name)}\.(.*)-(\d{{1,9}})-[0-9a-f]{{8}}\.({'|'.join(purposes)})")
    for path in out.parent.iterdir() if out.parent.is_dir() else ():
        if (match := pattern.fullmatch(path.name)) and _is_dead(host=match[1], pid=int(match[2])):
            shutil.rmtree(path, ignore_errors=True)


def _is_dead(host: str, pid: int) -> bool:
    """Whether a process is clearly dead; one of another computer, or where asking would end it, may well live."""
    if host != platform.node() or os.name != "posix":
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False  # it lives, and is somebody else's
    return False


def _remove_empty(folders: list[Path]) -> None:
    """Take back the folders that were made above the output, innermost first."""
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()

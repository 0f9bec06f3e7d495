"""Execution of one run in a worker process: takes a run, returns its row of results."""

import json
import socket
import sys
import time
import traceback
from pathlib import Path
from tempfile import TemporaryDirectory

from luxloop.printable import print_text
from luxloop.scenarios.errors import OutputError, StudyError
from luxloop.scenarios.exit_codes import INTERNAL_ERROR, ExitCode, explain, is_full
from luxloop.scenarios.files.shipped import CATALOG
from luxloop.scenarios.run.versions import Versions, installed
from luxloop.scenarios.study.design import StudyRun
from luxloop.scenarios.study.row_store import RowText, RunRow, as_text

BROKEN = ("error", "incomplete")
"""Status of runs excluded from statistics: they failed, or measured less time than the others."""

_printed: set[str] = set()
"""Places in the code whose internal error this process has printed; a defect may end every run of a study."""


def carry_out_as_texts(runs: list[StudyRun], keep_at: str | None, need: Versions) -> list[RowText]:
    """Execute runs one after the other as `carry_out`, and return their rows as text.

    Text is much cheaper to transfer: Dask serialises a dictionary item by item, which takes 30 ms per row.
    """
    return [as_text(carry_out(run, keep_at, need)) for run in runs]


def carry_out(run: StudyRun, keep_at: str | None = None, need: Versions | None = None) -> RunRow:
    """Execute a run and return its row; a run that fails returns a row with its error.

    Parameters
    ----------
    run
        The run.
    keep_at
        Folder or fsspec URL that receives the run's folder, named by the run's key; default: the folder is not kept.
    need
        Required package versions; default: no check.

    Raises
    ------
    StudyError
        The versions installed here differ from the required ones.
    OutputError
        The run's folder cannot be stored, or a disk is full: all other runs would fail as well.
    """
    if need and need != installed():
        raise StudyError(f"the worker on {socket.gethostname()} has {_differences(need)}; install the same there")
    start = time.perf_counter()
    row = first_columns(run)
    try:
        row |= _execute(run, keep_at)
    except OutputError:
        raise
    except Exception as error:  # a crash of one run must not end the study: its row holds the error
        if isinstance(error, OSError) and is_full(error):
            raise OutputError(f"{error.filename or socket.gethostname()}: {error.strerror}; free some space") from error
        row |= failed(_reason(error))
    return row | {"wall_s": time.perf_counter() - start}


def _reason(error: Exception) -> str:
    """Return the error of a run; that of a defect of luxloop is marked, and its traceback is printed."""
    code, message = explain(error)
    if code != ExitCode.INTERNAL:
        return message
    where = traceback.extract_tb(error.__traceback__)[-1]
    place = f"{Path(where.filename).name}:{where.lineno}"
    if place not in _printed:
        _printed.add(place)
        print_text("".join(traceback.format_exception(error)), sys.stderr, end="")
    return f"{INTERNAL_ERROR}{type(error).__name__}: {error} ({place})"


def first_columns(run: StudyRun) -> RunRow:
    """Return the columns that are known before the run."""
    known = {"index": run.index, "key": run.key, "seed": run.seed, "tracker": run.tracker, **run.parameters}
    return known | {"why": run.why, "inputs": json.dumps(run.inputs)}


def failed(error: str) -> RunRow:
    """Return the remaining columns of a run without a result."""
    return {"status": "error", "error": " ".join(error.split()), "trace_hash": "", "frames": 0, "wall_s": 0.0}


def _execute(run: StudyRun, keep_at: str | None) -> RunRow:
    from luxloop.scenarios.execute import execute
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.run import device, loop

    scenario, make_device = Scenario.of(run.document, CATALOG / run.path), device.load(run.tracker)
    if keep_at is None:
        result = loop.run(scenario, make_device)
    else:
        with TemporaryDirectory() as folder:
            result = execute(scenario, make_device, Path(folder) / run.key, record=False)
            _upload(Path(folder) / run.key, f"{keep_at.rstrip('/')}/{run.key}")
    return {
        "status": "passed" if result.verdict == "no limits" else result.verdict,  # most studies have no limits
        "error": result.ended_early,
        "trace_hash": result.trace_hash,
        "frames": result.frames,
        **{name: result.metrics[name].value for name in (*result.metrics, *run.metrics)},
    }


def _upload(folder: Path, url: str) -> None:
    """Copy a run's folder to a folder or fsspec URL."""
    import fsspec

    try:
        filesystem, path = fsspec.core.url_to_fs(url)
        if filesystem.exists(path):  # left by an earlier attempt whose worker died
            filesystem.rm(path, recursive=True)
        filesystem.put(f"{folder}/", f"{path}/", recursive=True)
    except (OSError, ValueError, ImportError) as error:
        raise OutputError(
            f"--keep {url}: cannot write there ({error}); free some space, or give another URL"
        ) from error


def _differences(need: Versions) -> str:
    """Return the packages whose installed version differs from the required one, with both versions."""
    return ", ".join(
        f"{name} {here}, this sweep {need.get(name)}" for name, here in installed().items() if here != need.get(name)
    )

"""What a worker does: one run in, one row out."""

import errno
import json
import socket
import time
import traceback
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from scenarios.errors import InputError, OutputError, StudyError
from scenarios.files.shipped import CATALOG
from scenarios.run.versions import Versions, installed
from scenarios.study.design import StudyRun

Row = dict[str, Any]
"""`index`, `key`, `seed`, `tracker`, the parameters by their keys, `status`, `error`, `trace_hash`, `frames`, `wall_s`,
and the value of every metric by its name; without one it may be missing."""

FIXED_COLUMNS = ("index", "key", "seed", "tracker", "status", "error", "trace_hash", "frames", "wall_s")

BROKEN = ("error", "incomplete")
"""Status of runs that are no measurement: they failed, or measured less time than the others."""

FULL = (errno.ENOSPC, errno.EDQUOT)
"""What a full disk says, whoever writes on it."""


def carry_out_as_text(run: StudyRun, keep_at: str | None, need: Versions) -> str:
    """As `carry_out`, in JSON without what has no value: Dask would take a row apart item by item, in 30 ms."""
    return json.dumps({name: value for name, value in carry_out(run, keep_at, need).items() if value is not None})


def carry_out(run: StudyRun, keep_at: str | None = None, need: Versions | None = None) -> Row:
    """Run, and return the row of it; what fails is a row with its error.

    Parameters
    ----------
    run
        What to run.
    keep_at
        Folder or fsspec URL in which the run's folder is kept, named by its key; nothing is kept if left out.
    need
        The versions that the row is to be made with; whatever is here if left out.

    Raises
    ------
    StudyError
        Other versions are installed here.
    OutputError
        The run's folder cannot be kept, or a disk is full: no other run would fare better.
    """
    if need and need != installed():
        raise StudyError(f"the worker on {socket.gethostname()} has {_other_than(need)}; install the same there")
    start = time.perf_counter()
    row = first_columns(run)
    try:
        row |= _outcome(run, keep_at)
    except OutputError:
        raise
    except InputError as error:
        row |= failed(str(error))
    except Exception as error:  # a crash of one run must not end the study: its row tells
        if isinstance(error, OSError) and error.errno in FULL:
            raise OutputError(f"{error.filename or socket.gethostname()}: {error.strerror}; make room there") from error
        where = traceback.extract_tb(error.__traceback__)[-1]
        row |= failed(f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})")
    return row | {"wall_s": time.perf_counter() - start}


def first_columns(run: StudyRun) -> Row:
    """What is known of a run before it runs."""
    return {"index": run.index, "key": run.key, "seed": run.seed, "tracker": run.tracker, **run.parameters}


def failed(error: str) -> Row:
    """Return the other columns of a run without a result."""
    return {"status": "error", "error": " ".join(error.split()), "trace_hash": "", "frames": 0, "wall_s": 0.0}


def _outcome(run: StudyRun, keep_at: str | None) -> Row:
    from scenarios.execute import execute
    from scenarios.files.expect import check, verdict
    from scenarios.files.scenario import Scenario
    from scenarios.run import device, loop

    scenario, make_device = Scenario.of(run.document, CATALOG / run.path), device.load(run.tracker)
    if keep_at is None:
        result = loop.run(scenario, make_device)
        status = verdict(check(result.metrics, scenario.expect), result.complete)
    else:
        with TemporaryDirectory() as folder:
            outcome = execute(scenario, make_device, Path(folder) / run.key, record=False)
            _put(Path(folder) / run.key, f"{keep_at.rstrip('/')}/{run.key}")
        result, status = outcome.result, outcome.verdict
    return {
        "status": status,
        "error": result.ended_early,
        "trace_hash": result.trace_hash,
        "frames": result.frames,
        **{name: metric.value for name, metric in result.metrics.items()},
    }


def _put(folder: Path, url: str) -> None:
    """Copy a run's folder to where it is kept."""
    import fsspec

    try:
        filesystem, path = fsspec.core.url_to_fs(url)
        if filesystem.exists(path):  # of an attempt whose worker died before it could tell
            filesystem.rm(path, recursive=True)
        filesystem.put(f"{folder}/", f"{path}/", recursive=True)
    except (OSError, ValueError, ImportError) as error:
        raise OutputError(f"--keep {url}: cannot write there ({error}); make room, or give another URL") from error


def _other_than(need: Versions) -> str:
    """Tell what is installed here and what was wanted."""
    return ", ".join(
        f"{name} {here}, this sweep {need.get(name)}" for name, here in installed().items() if here != need.get(name)
    )

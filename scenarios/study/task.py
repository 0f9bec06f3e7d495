"""What a worker does: one run in, one row out."""

import time
import traceback
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from scenarios.errors import InputError
from scenarios.study.design import Run

Row = dict[str, Any]
"""`index`, `key`, `seed`, the parameters by their keys, `status`, `error`, `trace_hash`, `frames`, `wall_s`, and the value
of every metric by its name."""

FIXED_COLUMNS = ("index", "key", "seed", "status", "error", "trace_hash", "frames", "wall_s")


def carry_out(run: Run, keep_at: str | None = None) -> Row:
    """Run, and return the row of it; what fails is a row with its error.

    Parameters
    ----------
    run
        What to run.
    keep_at
        Folder or fsspec URL in which the run's folder is kept, named by its key; nothing is kept if left out.
    """
    start = time.perf_counter()
    row: Row = {"index": run.index, "key": run.key, "seed": run.seed, **run.parameters}
    try:
        row |= _outcome(run, keep_at)
    except InputError as error:
        row |= _failed(str(error))
    except Exception as error:  # a crash of one run must not end the study: its row tells
        where = traceback.extract_tb(error.__traceback__)[-1]
        row |= _failed(f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})")
    return row | {"wall_s": time.perf_counter() - start}


def _failed(error: str) -> Row:
    return {"status": "error", "error": " ".join(error.split()), "trace_hash": "", "frames": 0}


def _outcome(run: Run, keep_at: str | None) -> Row:
    from scenarios import device, loop
    from scenarios.execute import execute
    from scenarios.expect import check, verdict
    from scenarios.scenario import Scenario

    scenario, make_device = Scenario.of(run.document, run.path), device.load(run.tracker)
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

    filesystem, path = fsspec.core.url_to_fs(url)
    if filesystem.exists(path):  # of an attempt whose worker died before it could tell
        filesystem.rm(path, recursive=True)
    filesystem.put(f"{folder}/", f"{path}/", recursive=True)

"""Runs of the league: scans of each scenario and seed are recorded once, and all trackers get them.

Folders: `scans/SCENARIO-seedN` are recorded runs, `runs/TRACKER/SCENARIO-seedN` the graded ones, `rows/` a file per
run, written when it has ended. A second start takes up rows whose scans, code and settings are the same.
"""

import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import ContractError
from luxloop.scenarios.files.expect import check
from luxloop.scenarios.league.drive import Drive
from luxloop.scenarios.league.drive_scans import ROWS, code_digest, scans_digest, scans_of
from luxloop.scenarios.league.entrants import Entrant, chosen
from luxloop.scenarios.league.json_file import write_json
from luxloop.scenarios.offline.recorded_run import RecordedRun
from luxloop.scenarios.offline.regrade import Regrader
from luxloop.scenarios.report import text
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.run.progress import hidden
from luxloop.sim.source import SimulatorFailedError, TrafficEndedError

RUNS = "runs"
FIGURES = {
    "hota": "track.hota", "id_switches": "track.id_switches", "gospa_m": "track.gospa_m", "false": "track.false",
    "missed": "track.missed", "step_ms_p50": "perf.tracker_ms_p50", "step_ms_p99": "perf.tracker_ms_p99",
}  # fmt: skip
"""Columns of a row, with their metrics."""

Row = dict[str, Any]


def carry_out(todo: Sequence[Drive], workers: int) -> Iterator[list[Row]]:
    """Yield the rows of each drive as it ends; drives are shared among processes."""
    if workers == 1:
        yield from map(run_drive, todo)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(run_drive, drive) for drive in todo]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            for child in active_children():
                child.terminate()  # the rows of finished runs are on the disk
            pool.shutdown(cancel_futures=True)
            raise


def run_drive(drive: Drive) -> list[Row]:
    """Record the scans of a drive, unless they are there, and run all trackers on them."""
    code = code_digest(drive)
    with hidden():
        entrants = chosen(drive.trackers)
        rows = [_earlier(drive, entrant, code) for entrant in entrants]
        if all(rows):
            return [row for row in rows if row]
        try:
            recorded = scans_of(drive, code)
        except (SimulatorFailedError, TrafficEndedError) as error:
            return [_finish(drive, each, {"code": code, **_failure(error)}) for each in entrants]
        scans = scans_digest(recorded.folder)
        key = {"code": code, "scans": scans}
        done = zip(entrants, rows, strict=True)
        return [row or _finish(drive, each, key | graded(drive, each, recorded)) for each, row in done]


def row_path(drive: Drive, tracker: str) -> Path:
    """Return the file of a row."""
    return drive.out / ROWS / f"{tracker}-{drive.name}.json"


def _earlier(drive: Drive, entrant: Entrant, code: str) -> Row | None:
    """Return the row of an earlier start, if code, settings and duration are the same."""
    try:
        row: Row = json.loads(row_path(drive, entrant.name).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    same = {"code": code, "settings": entrant.digest, "duration_max_s": drive.duration_max_s}
    return row if same.items() <= row.items() else None


def graded(drive: Drive, entrant: Entrant, recorded: RecordedRun) -> Row:
    """Run a tracker on the scans, write its folder, and return its figures; a broken contract is a failure."""
    try:
        result = Regrader(recorded, recorded.scenario).tracker(entrant, entrant.name)
    except ContractError as error:
        return _failure(error)
    checks = check(result.metrics, recorded.scenario.expect, entrant.name)
    with run_folder.create(drive.out / RUNS / entrant.name / drive.name) as folder:
        run_folder.write(folder, result, checks, text.as_text(text.report(result, checks)))
    return {
        "status": "incomplete" if result.ended_early else "finished",
        "error": result.ended_early,
        **_figures(result),
    }


def _figures(result: Result) -> Row:
    values = {name: result.metrics[metric].value for name, metric in FIGURES.items()}
    return {"trace_hash": result.trace_hash, "frames": result.frames, **values}


def _failure(error: Exception) -> Row:
    return {"status": "failed", "error": " ".join(str(error).split()), **dict.fromkeys(FIGURES)}


def _finish(drive: Drive, entrant: Entrant, found: Row) -> Row:
    """Write the row of a run and return it."""
    key = {"tracker": entrant.name, "scenario": drive.stem, "seed": drive.seed}
    row = {**key, "duration_max_s": drive.duration_max_s, "settings": entrant.digest, **found}
    write_json(row_path(drive, entrant.name), row)
    return row

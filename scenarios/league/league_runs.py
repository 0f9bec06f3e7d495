"""Runs of the league: scans of each scenario and seed are recorded once, and all trackers get them.

Folders: `scans/SCENARIO-seedN` are recorded runs, `runs/TRACKER/SCENARIO-seedN` the graded ones. The rows are in
`runs.sqlite`. A second start takes up rows whose scans, code and settings are the same.
"""

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing import active_children, connection, get_context, parent_process
from typing import Any

from luxloop.scenarios.errors import ContractError
from luxloop.scenarios.files.expect import check
from luxloop.scenarios.league.drive import Drive, code_digest, scans_digest, scans_of
from luxloop.scenarios.league.entrants import Entrant, chosen
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.scenarios.offline.regrade import Regrader
from luxloop.scenarios.report import text
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.run.progress import hidden
from luxloop.scenarios.run.termination import as_interrupts, is_interrupt, start_resource_tracker
from luxloop.scenarios.study.row_store import RowStore, as_text
from luxloop.scenarios.study.run_content import digest
from luxloop.sim.source import SimulatorFailedError, TrafficEndedError

RUNS = "runs"
FIGURES = {
    "hota": "track.hota", "id_switches": "track.id_switches", "gospa_m": "track.gospa_m", "false": "track.false",
    "missed": "track.missed", "step_ms_p50": "perf.tracker_ms_p50", "step_ms_p99": "perf.tracker_ms_p99",
}  # fmt: skip
"""Columns of a row, with their metrics."""

COLUMNS = ("scenario", "duration_max_s", "settings", "code", "scans", *FIGURES)
"""Columns of a row besides those of all rows."""

Row = dict[str, Any]
Missing = tuple[Drive, list[Entrant]]
"""A drive and its trackers without a row."""


def carry_out(todo: Sequence[Drive], workers: int) -> Iterator[Row]:
    """Yield the row of each drive and tracker: those of earlier starts, then the others as their runs end.

    Raises
    ------
    OutputError
        A row cannot be stored, or another process writes to the folder.
    """
    with RowStore.opened(todo[0].out, COLUMNS) as rows:
        earlier = {row.pop("key"): row for row in rows.facts()}
        missing: list[Missing] = []
        for drive in todo:
            entrants = {row_key(drive, each): each for each in chosen(drive.trackers)}
            yield from (earlier[key] for key in entrants if key in earlier)
            if new := [each for key, each in entrants.items() if key not in earlier]:
                missing.append((drive, new))
        for key, row in _in_turn(missing) if workers == 1 else _in_processes(missing, workers):
            rows.add([as_text({"key": key, **row})])
            yield row


def row_key(drive: Drive, entrant: Entrant) -> str:
    """Return the digest of everything that determines the row of a tracker."""
    return digest([entrant.name, entrant.digest, drive.name, drive.duration_max_s, code_digest(drive)])


def _in_turn(missing: Sequence[Missing]) -> Iterator[tuple[str, Row]]:
    for drive, entrants in missing:
        scans = recorded_scans(drive)
        for each in entrants:
            yield run_tracker(drive, each, scans)


def _in_processes(missing: Sequence[Missing], workers: int) -> Iterator[tuple[str, Row]]:
    """Record the scans of all drives, and run the trackers of each as soon as its scans are there."""
    start_resource_tracker()
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_end_with_parent) as pool:
        pending: dict[Future[Any], Missing | None] = {
            pool.submit(_in_worker, recorded_scans, one[0]): one for one in missing
        }
        try:
            while pending:
                for future in wait(pending, return_when=FIRST_COMPLETED).done:
                    recorded = pending.pop(future)
                    if recorded is None:
                        yield future.result()
                    else:
                        drive, entrants = recorded
                        new = [pool.submit(_in_worker, run_tracker, drive, each, future.result()) for each in entrants]
                        pending |= dict.fromkeys(new)
        except BaseException:
            for child in active_children():
                child.terminate()  # the rows of finished runs are on the disk
            pool.shutdown(cancel_futures=True)
            raise


def _in_worker(task: Callable[..., Any], *arguments: Any) -> Any:
    """Run a task in a worker; SIGTERM ends it by an exception, so that its temporary folder is removed."""
    with as_interrupts() as received:
        try:
            return task(*arguments)
        except BaseException as error:
            if is_interrupt(error):
                os._exit(received.exit_code)
            raise


def _end_with_parent() -> None:
    """End this process when that of the command is gone, which was killed: the pool would wait for tasks forever."""
    parent = parent_process()
    assert parent

    def end() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=end, daemon=True).start()


def recorded_scans(drive: Drive) -> Row:
    """Record the scans of a drive, unless they are there; return their digest, or the failure of the traffic."""
    try:
        with hidden():
            return {"scans": scans_digest(scans_of(drive, code_digest(drive)).folder)}
    except (SimulatorFailedError, TrafficEndedError) as error:
        return {"scans": None, **_failure(error)}


def run_tracker(drive: Drive, entrant: Entrant, scans: Row) -> tuple[str, Row]:
    """Run a tracker on the recorded scans of a drive, unless the traffic failed; return its row with its key."""
    code = code_digest(drive)
    with hidden():
        found = {} if "status" in scans else graded(drive, entrant, scans_of(drive, code))
    row = {
        "tracker": entrant.name, "scenario": drive.stem, "seed": drive.seed, "duration_max_s": drive.duration_max_s,
        "settings": entrant.digest, "code": code, **scans, **found,
    }  # fmt: skip
    return row_key(drive, entrant), row


def graded(drive: Drive, entrant: Entrant, recorded: RecordedRun) -> Row:
    """Run a tracker on the scans, write its folder, and return its figures; a broken contract is a failure."""
    try:
        result = Regrader(recorded, recorded.scenario).tracker(entrant.factory, entrant.name)
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
    none = dict.fromkeys(("trace_hash", "frames", *FIGURES))
    return {"status": "failed", "error": " ".join(str(error).split()), **none}

"""Runs of the league: scans of each scenario and seed are recorded once, and all trackers get them.

Folders: `scans/SCENARIO-seedN` are recorded runs, `runs/TRACKER/SCENARIO-seedN` the graded ones, `rows/` a file per
run, written when it has ended. A second start takes up rows whose scans, code and settings are the same.
"""

import hashlib
import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

from scenarios.errors import ContractError, InputError, OutputError
from scenarios.execute import execute
from scenarios.files import atomic_file, shipped
from scenarios.files.expect import check
from scenarios.files.scenario import Scenario
from scenarios.league.entrants import Entrant, chosen
from scenarios.offline.recorded_run import RecordedRun
from scenarios.offline.regrade import Regrader
from scenarios.report import text
from scenarios.result import Result
from scenarios.run import run_folder
from scenarios.run.progress import hidden
from scenarios.study import source_code
from sim.source import SimulatorFailedError, TrafficEndedError
from tracker.records import Tracks
from tracker.scan import Scan
from tracker.tracker import TrackerConfig

SCANS, RUNS, ROWS = "scans", "runs", "rows"
CODE = ("sim", "sensor_model", "tracker", "scenarios/grading", "scenarios/league/trackers")
"""Folders of luxloop whose code determines a row."""
FIGURES = {
    "hota": "track.hota", "id_switches": "track.id_switches", "gospa_m": "track.gospa_m", "false": "track.false",
    "missed": "track.missed", "step_ms_p50": "perf.tracker_ms_p50", "step_ms_p99": "perf.tracker_ms_p99",
}  # fmt: skip
"""Columns of a row, with their metrics."""

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Drive:
    """Scenario and seed that all trackers get."""

    scenario: str
    """Path of its file."""
    seed: int
    duration_max_s: float
    trackers: tuple[str, ...]
    out: Path

    @property
    def stem(self) -> str:
        """Name of the scenario."""
        return Path(self.scenario).stem

    @property
    def name(self) -> str:
        """Name of its folders."""
        return f"{self.stem}-seed{self.seed}"

    def load(self) -> Scenario:
        """Return the scenario, shortened to the largest duration.

        Raises
        ------
        InputError
            The ego drives by the tracks, so that the scans depend on the tracker.
        """
        path = Path(self.scenario)
        scenario = Scenario.load(path, {"seed": self.seed})
        if scenario.control:
            raise InputError(f"{path}: control: the ego drives by its tracks, so trackers would have different scans")
        return Scenario.load(path, {"seed": self.seed, "duration_s": min(self.duration_max_s, scenario.duration_s)})


class NoTracks:
    """Device without tracks, for the recording of scans."""

    def __init__(self, _config: TrackerConfig) -> None:
        pass

    def step(self, _scan: Scan) -> Tracks:
        """Return no tracks."""
        return Tracks.from_boxes([], [], [], [])


def drives(
    scenarios: Sequence[str], seeds: Sequence[int], duration_max_s: float, trackers: Sequence[str], out: Path
) -> list[Drive]:
    """Return all combinations of scenarios and seeds.

    Raises
    ------
    InputError, ScenarioError
        A scenario or tracker does not exist, two scenarios have the same name, or one cannot be in a league.
    """
    names = tuple(entrant.name for entrant in chosen(trackers))
    files = [str(shipped.find(name)) for name in scenarios]
    stems = [Path(file).stem for file in files]
    for stem in stems:
        if stems.count(stem) > 1:
            raise InputError(f"{stem}: given twice; scenarios of a league need different names")
    found = [Drive(file, seed, duration_max_s, names, out) for seed in seeds for file in files]
    for drive in found:
        drive.load()
    return found


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


def record(drive: Drive) -> str:
    """Record the scans of a drive only, and return the name of its folder."""
    with hidden():
        scans_of(drive, code_digest(drive))
    return drive.name


def code_digest(drive: Drive) -> str:
    """Return the digest of the code and of the scenario that determine the rows of a drive."""
    code = source_code.of_folders(*CODE)
    return hashlib.blake2b(f"{code} {drive.load().model_dump_json()}".encode(), digest_size=12).hexdigest()


def scans_digest(folder: Path) -> str:
    """Return the digest of the files of recorded scans: what every tracker gets."""
    digest = hashlib.blake2b(digest_size=12)
    for path in sorted((folder / run_folder.SCANS).glob("*.parquet")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


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


def scans_of(drive: Drive, code: str) -> RecordedRun:
    """Return the recorded scans; those of another duration or code are recorded again."""
    folder, mark = drive.out / SCANS / drive.name, drive.out / ROWS / f"scans-{drive.name}.json"
    made_by = {"code": code, "duration_max_s": drive.duration_max_s}
    try:
        if json.loads(mark.read_text(encoding="utf-8")) == made_by:
            return RecordedRun.open(folder)
    except (OSError, ValueError, OutputError):
        pass
    execute(drive.load(), NoTracks, folder, record=False, record_scans=True)
    write_json(mark, made_by)
    return RecordedRun.open(folder)


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


def write_json(path: Path, content: object) -> None:
    """Write a file atomically.

    Raises
    ------
    OutputError
        It cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_file.create(path) as temporary:
            temporary.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot write there ({error.strerror}); choose another folder with --out") from error

"""Recorded scans of a drive, which all trackers get."""

import hashlib
import json
from functools import cache
from pathlib import Path

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.execute import execute
from luxloop.scenarios.league.drive import Drive
from luxloop.scenarios.league.json_file import write_json
from luxloop.scenarios.offline.recorded_run import RecordedRun
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.run.device import NoTracks
from luxloop.scenarios.run.progress import hidden
from luxloop.scenarios.study import run_content

SCANS = "scans"
CODE = ("sim", "sensor_model", "tracker", "scenarios/grading", "scenarios/league/trackers")
"""Folders of luxloop whose code determines a row."""


def record(drive: Drive) -> str:
    """Record the scans of a drive only, and return the name of its folder."""
    with hidden():
        scans_of(drive, code_digest(drive))
    return drive.name


def scans_of(drive: Drive, code: str) -> RecordedRun:
    """Return the recorded scans; those of another duration or code are recorded again."""
    folder, mark = drive.out / SCANS / drive.name, drive.out / SCANS / f"{drive.name}.json"
    made_by = {"code": code, "duration_max_s": drive.duration_max_s}
    try:
        if json.loads(mark.read_text(encoding="utf-8")) == made_by:
            return RecordedRun.open(folder)
    except (OSError, ValueError, OutputError):
        pass
    execute(drive.load(), NoTracks, folder, record=False, record_scans=True)
    write_json(mark, made_by)
    return RecordedRun.open(folder)


def code_digest(drive: Drive) -> str:
    """Return the digest of the code and of the scenario that determine the rows of a drive."""
    return hashlib.blake2b(f"{_sources()} {drive.load().model_dump_json()}".encode(), digest_size=12).hexdigest()


@cache
def _sources() -> str:
    return run_content.of_folders(*CODE)


def scans_digest(folder: Path) -> str:
    """Return the digest of the files of recorded scans: what every tracker gets."""
    digest = hashlib.blake2b(digest_size=12)
    for path in sorted((folder / run_folder.SCANS).glob("*.parquet")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()

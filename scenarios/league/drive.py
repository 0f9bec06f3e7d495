"""Drives of a league: combinations of scenarios and seeds, and their recorded scans."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from luxloop.scenarios.errors import InputError, OutputError
from luxloop.scenarios.execute import execute
from luxloop.scenarios.files import atomic_file, shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.league.entrants import chosen
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.run.device import NoTracks
from luxloop.scenarios.run.progress import hidden
from luxloop.scenarios.study import run_content


@dataclass(frozen=True, slots=True)
class Drive:
    """Scenario and seed that all trackers get."""

    scenario: str
    """Path of its file."""
    seed: int
    duration_max_s: float
    trackers: tuple[str, ...]
    """Names, and places of the user's own."""
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


def drives(
    scenarios: Sequence[str], seeds: Sequence[int], duration_max_s: float, trackers: Sequence[str], out: Path
) -> list[Drive]:
    """Return all combinations of scenarios and seeds.

    Raises
    ------
    InputError, ScenarioError
        A scenario or tracker does not exist, two scenarios have the same name, or one cannot be in a league.
    """
    specs = tuple(entrant.spec for entrant in chosen(trackers))
    files = [str(shipped.find(name)) for name in scenarios]
    stems = [Path(file).stem for file in files]
    for stem in stems:
        if stems.count(stem) > 1:
            raise InputError(f"{stem}: given twice; scenarios of a league need different names")
    found = [Drive(file, seed, duration_max_s, specs, out) for seed in seeds for file in files]
    for drive in found:
        drive.load()
    return found


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
    atomic_file.save_text(mark, json.dumps(made_by, indent=1) + "\n")
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

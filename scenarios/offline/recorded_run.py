"""A run that is on disk, whole, with what it followed: what `luxloop grade` starts from."""

import json
import os
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from pydantic import TypeAdapter, ValidationError

from scenarios.errors import OutputError
from scenarios.files import atomic_folder
from scenarios.files.scenario import Scenario
from scenarios.grading import frame_tables
from scenarios.grading.frame_tables import Schema
from scenarios.offline.recorded_scans import RecordedScans
from scenarios.result import Result
from scenarios.run import run_folder
from sensor_model.rig.rig import Rig

NOT_OF_THE_SCENARIO = ("rig", "device")
"""Keys of the effective config that a scenario file has not, or not like this."""


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """A whole run."""

    folder: Path
    result: Result
    scenario: Scenario
    """What it followed."""
    rig: Rig

    @classmethod
    def open(cls, folder: Path) -> "RecordedRun":
        """Read a run back.

        Raises
        ------
        OutputError
            The folder holds no run, not the whole of one, or one whose settings or tables have changed since.
        """
        if atomic_folder.is_unfinished(folder):
            raise OutputError(f"{folder}: was left by a run that was killed; run the scenario again")
        result = run_folder.read(folder)
        restored = {name: _restore(folder, result, name, schema) for name, schema in frame_tables.SCHEMAS.items()}
        settings = {key: value for key, value in result.config.items() if key not in NOT_OF_THE_SCENARIO}
        try:
            scenario = Scenario.model_validate_json(json.dumps(settings))
            rig = TypeAdapter(Rig).validate_python(result.config["rig"])
        except (ValidationError, KeyError) as error:
            raise OutputError(
                f"{folder}: luxloop {result.versions.get('luxloop')} made it with settings that are others now; "
                "run the scenario again"
            ) from error
        result.tables.update(restored)
        return cls(folder, result, scenario, rig)

    def refuse_to_write_to(self, out: Path) -> None:
        """Raise an OutputError if results at `out` would replace the run, or lie in it or around it."""
        here, there = (Path(os.path.realpath(folder)) for folder in (self.folder, out))
        if there.is_relative_to(here) or here.is_relative_to(there):
            raise OutputError(f"{out}: is the run that is graded, or in it or around it; choose another with --out")

    def scans(self) -> RecordedScans:
        """Its scans and their truth.

        Raises
        ------
        OutputError
            As `RecordedScans`.
        """
        return RecordedScans(self.folder, self.result.frames, len(self.rig.mounts))


def _restore(folder: Path, result: Result, name: str, schema: Schema) -> pd.DataFrame:
    """Return a table with all categories of its enumerations, in the order of their codes."""
    table = result.tables.get(name)
    missing = [name] if table is None else [column for column in schema if column not in table]
    if table is None or missing:
        raise OutputError(f"{folder}: no {missing[0]} in its tables; run the scenario again")
    kinds = {column: pd.CategoricalDtype(kind) for column, kind in schema.items() if isinstance(kind, tuple)}
    return table.astype(kinds)

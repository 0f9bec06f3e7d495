"""Completed run read from disk, with its scenario and rig: the input of `luxloop grade`."""

import os
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from pydantic import TypeAdapter, ValidationError

from luxloop.plugins import PluginError
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading import fit_errors, frame_tables
from luxloop.scenarios.grading.frame_tables import Schema, with_added
from luxloop.scenarios.offline.recorded_scans import RecordedScans
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder
from luxloop.sensor_model.rig.beams import beam_table, sweep_limits
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sim.factory import KINDS

TRACK_HEIGHT_M = 1.5
"""Height of the boxes of tracks in other formats; the tracker estimates none."""
NOT_IN_SCENARIO = ("rig", "device", "set", "ego", "in_process")
"""Keys of the effective config that are not in a scenario file, or have another form there."""


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """A completed run."""

    folder: Path
    result: Result
    scenario: Scenario
    """Scenario of the run, from its effective config."""
    rig: Rig

    @classmethod
    def open(cls, folder: Path) -> "RecordedRun":
        """Read a run from its folder.

        Raises
        ------
        OutputError
            The folder holds no run, an incomplete one, or one of a version with other settings or tables.
        """
        result = run_folder.read(folder)
        restored = {name: _restore(folder, result, name, schema) for name, schema in frame_tables.SCHEMAS.items()}
        settings = {key: value for key, value in result.config.items() if key not in NOT_IN_SCENARIO}
        try:
            scenario = Scenario.parse(settings)
            rig = TypeAdapter(Rig).validate_python(result.config["rig"])
        except PluginError as error:
            raise OutputError(f"{folder}: its traffic: {error}") from error
        except (ValidationError, KeyError) as error:
            raise OutputError(f"{folder}: {_misfit(result)}") from error
        result.tables.update(restored, fits=fit_errors.measure(restored["fits"]))
        return cls(folder, result, scenario, rig)

    def refuse_to_write_to(self, out: Path) -> None:
        """Raise an OutputError if `out` is the folder of the run, inside it, or contains it."""
        here, there = (Path(os.path.realpath(folder)) for folder in (self.folder, out))
        if there.is_relative_to(here) or here.is_relative_to(there):
            raise OutputError(
                f"{out}: is the folder of the graded run, inside it, or contains it; choose another with --out"
            )

    def scans(self) -> RecordedScans:
        """Return the recorded scans with their ground truth.

        Raises
        ------
        OutputError
            As for `RecordedScans`.
        """
        beams = beam_table(self.rig)
        limits = sweep_limits(beams) if self.scenario.sensor.sweep else None
        positions = beams.units.origin_ego[:, :2]
        return RecordedScans(self.folder, self.result.frames, len(self.rig.mounts), limits, positions)


def _misfit(result: Result) -> str:
    """Return the reason why the settings of a run are not valid here, with a remedy."""
    traffic = result.config.get("traffic")
    kind = traffic.get("kind") if isinstance(traffic, dict) else None
    if isinstance(kind, str) and kind not in KINDS.names():
        return f'traffic.kind = "{kind}" is of a plug-in that is not installed; install it'
    version = result.versions.get("luxloop")
    return f"written by luxloop {version}, whose settings differ from this version's; run the scenario again"


def _restore(folder: Path, result: Result, name: str, schema: Schema) -> pd.DataFrame:
    """Return a table of the run; enumeration columns have all categories, in the order of their codes."""
    table = result.tables.get(name)
    if table is not None:
        table = with_added(name, table)
    missing = [name] if table is None else [column for column in schema if column not in table]
    if table is None or missing:
        raise OutputError(f"{folder}: {missing[0]} is missing in its tables; run the scenario again")
    kinds = {column: pd.CategoricalDtype(kind) for column, kind in schema.items() if isinstance(kind, tuple)}
    return table.astype(kinds)

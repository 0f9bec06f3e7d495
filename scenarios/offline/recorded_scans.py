"""A recorded run, and its scans with frames and ground truth, exactly as in the run."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
from pydantic import TypeAdapter, ValidationError

from luxloop.arrays import Floats, Floats32
from luxloop.plugins import PluginError
from luxloop.scenarios.dataset import dataset_rows
from luxloop.scenarios.dataset.dataset_columns import FILES, Column, Values
from luxloop.scenarios.dataset.dataset_rows import records_of
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_folder
from luxloop.scenarios.files.input_file import open_parquet, read_parquet
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.grading import fit_errors, frame_tables
from luxloop.scenarios.grading.frame_tables import Schema
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder
from luxloop.sensor_model.rig.beams import beam_table, sweep_limits
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.truth import NO_ACTOR, ScanTruth
from luxloop.sim.factory import KINDS
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.scan import Scan

REMEDY = "run the scenario again with --record-scans"
ROWS_AT_ONCE = 1 << 17
"""Batch size of reading; a recording may be larger than memory."""


class RecordedScans:
    """Iterable over the frames of a run in order; can be iterated repeatedly.

    Parameters
    ----------
    run
        Folder of the run.
    frames
        Number of frames of the run.
    units
        Number of LIDARs of its rig.
    sweep_limits
        Fields of view of their layers, see `luxloop.tracker.scan.Scan.sweep_limits`; they are not recorded.
    unit_positions_ego
        Positions of the units, see `luxloop.tracker.scan.Scan.unit_positions_ego`; they are not recorded.

    Raises
    ------
    OutputError
        The run has no scans, or not all of them.
    """

    def __init__(
        self,
        run: Path,
        frames: int,
        units: int,
        sweep_limits: Floats32 | None = None,
        unit_positions_ego: Floats | None = None,
    ) -> None:
        self._folder, self._units = run / run_folder.SCANS, units
        self._sweep_limits, self._unit_positions_ego = sweep_limits, unit_positions_ego
        if not self._folder.is_dir():
            raise OutputError(f"{run}: has no recorded scans; {REMEDY}")
        with readable(self._folder, REMEDY):
            scans = read_parquet(self._folder / "scans.parquet", ["frame", "time_s"])
            self.time_s: Floats = scans["time_s"].cast(pa.float64()).to_numpy()
            """(F,) times of the frames [s]."""
            require_numbers({"time_s": self.time_s})
        if scans["frame"].to_pylist() != list(range(frames)):
            raise OutputError(
                f"{self._folder}: has {len(self.time_s)} frames, but the run has {frames}; run the scenario again"
            )

    def __len__(self) -> int:
        return len(self.time_s)

    def obstacles(self) -> Obstacles:
        """Return the static obstacles; those of the run.

        Raises
        ------
        OutputError
            Their file is damaged.
        """
        with readable(self._folder, REMEDY):
            return dataset_rows.read(self._folder)

    def __iter__(self) -> Iterator[tuple[WorldFrame, Scan, ScanTruth]]:
        with readable(self._folder, REMEDY):
            files = {name: FrameRows(self._folder / f"{name}.parquet", columns) for name, columns in FILES.items()}
        for frame in range(len(self)):
            with readable(self._folder, REMEDY):
                rows = {name: file.of(frame) for name, file in files.items()}
                _require_plausible(rows)
            yield records_of(rows, self._units, self._sweep_limits, self._unit_positions_ego)


class FrameRows:
    """Reader of one file of a data set, frame by frame."""

    def __init__(self, path: Path, columns: tuple[Column, ...]) -> None:
        self._batches = (
            {column.name: column.values(batch[column.name]) for column in columns}
            for batch in open_parquet(path).iter_batches(ROWS_AT_ONCE, columns=[column.name for column in columns])
        )
        self._waiting: Values = {column.name: column.values(pa.array([], column.type)) for column in columns}

    def of(self, frame: int) -> Values:
        """Return the rows of a frame; frames must be requested in order.

        Raises
        ------
        ValueError
            The rows of the file are not in the order of frames.
        """
        while not len(self._waiting["frame"]) or self._waiting["frame"][-1] <= frame:
            batch = next(self._batches, None)
            if batch is None:
                break
            self._waiting = {name: np.concatenate([values, batch[name]]) for name, values in self._waiting.items()}
            if np.any(np.diff(self._waiting["frame"]) < 0):
                raise ValueError("the rows should be in the order of column frame")
        end = int(np.searchsorted(self._waiting["frame"], frame, side="right"))
        rows = {name: values[:end] for name, values in self._waiting.items()}
        self._waiting = {name: values[end:] for name, values in self._waiting.items()}
        return rows


def _require_plausible(rows: dict[str, Values]) -> None:
    """Raise a ValueError for numbers that no scan has, and for tables of a frame that contradict each other."""
    for values in rows.values():
        require_numbers(values)
    require_distinct(rows["labels"])
    require_actors(rows["points"], rows["labels"])


@contextmanager
def readable(folder: Path, remedy: str) -> Iterator[None]:
    """Raise errors of missing or damaged files as an OutputError of one line that ends with the remedy."""
    try:
        yield
    except (OSError, pa.ArrowException, LookupError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise OutputError(f"{folder}: cannot be read ({reason}); {remedy}") from error


LARGEST = {"time_s": 1e11, "length_m": 200.0, "width_m": 200.0, "height_m": 200.0}
"""Absolute values by column."""
LARGEST_OTHER = 1e7
"""Absolute value in all other columns of numbers, in any unit."""
SIZES = ("length_m", "width_m", "height_m")
UNIQUE = ("frame", "actor_id")


def require_numbers(values: Values) -> None:
    """Check columns of numbers: finite and of a plausible size; sizes of vehicles are positive.

    Raises
    ------
    ValueError
        A cell is not; the message names its column.
    """
    for name, column in values.items():
        if column.dtype.kind == "f" and not np.all(np.abs(column) <= LARGEST.get(name, LARGEST_OTHER)):
            raise ValueError(f"column {name}: {_worst(column):g} is no plausible number")
    for name in SIZES:
        if name in values and not np.all(values[name] > 0.0):
            raise ValueError(f"column {name}: should be positive")


def require_actors(points: Values, labels: Values) -> None:
    """Check that every point on an actor has the label of the actor in the frame.

    Raises
    ------
    ValueError
        One has none.
    """
    on_actors = points["actor_id"][points["actor_id"] != NO_ACTOR]
    if not np.isin(on_actors, labels["actor_id"]).all():
        raise ValueError("labels.parquet: an actor with points has no label")


def require_distinct(labels: Values) -> None:
    """Check that each actor has one label in a frame.

    Raises
    ------
    ValueError
        One has two.
    """
    rows = np.column_stack([labels[name] for name in UNIQUE])
    if len(np.unique(rows, axis=0)) < len(rows):
        raise ValueError("labels.parquet: an actor has two labels in a frame")


def _worst(column: Floats) -> float:
    """Return the first number that is not finite, or else the largest."""
    wrong = column[~np.isfinite(column)]
    return float(wrong[0] if len(wrong) else column[np.argmax(np.abs(column))])


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
        if atomic_folder.overlap(self.folder, out):
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
    missing = [name] if table is None else [column for column in schema if column not in table]
    if table is None or missing:
        raise OutputError(f"{folder}: {missing[0]} is missing in its tables; run the scenario again")
    kinds = {column: pd.CategoricalDtype(kind) for column, kind in schema.items() if isinstance(kind, tuple)}
    return table.astype(kinds)

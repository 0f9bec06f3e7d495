"""Recorded scans of a run, with frames and ground truth, exactly as in the run."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa

from luxloop.scenarios.arrays import Floats, Floats32
from luxloop.scenarios.dataset import dataset_rows
from luxloop.scenarios.dataset.dataset_columns import FILES, Column, Values
from luxloop.scenarios.dataset.dataset_rows import records_of
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files.plain_file import open_parquet, read_parquet
from luxloop.scenarios.run import run_folder
from luxloop.sensor_model.truth import NO_ACTOR, ScanTruth
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
        """Return the static obstacles; none for runs of versions that did not record them.

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

"""Tables of grading: their columns, and a builder that joins the rows of single frames.

Every table starts with `frame` and `time_s`. Enumerations are categories by name; -1 means "no actor" or "no track".
"""

import tempfile
import weakref
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from itertools import product
from typing import IO, Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.grading.articulated import ARTICULATION
from luxloop.scenarios.grading.matching import TrackVerdict
from luxloop.scenarios.metrics.definitions import CANDIDATES, HORIZONS, VIEWS, estimates
from luxloop.sensor_model.truth import Cause, View
from luxloop.sim.world import Kind, WorldFrame
from luxloop.tracker.records import MODEL_NAMES, MODELS, Status


class ColumnSpool:
    """Arrays by column name, in the order in which they were added; the file has no name and ends with this object."""

    def __init__(self) -> None:
        self._file: IO[bytes] | None = None
        self._arrays: dict[str, list[tuple[int, int, np.dtype[Any]]]] = {}

    def append(self, name: str, array: npt.NDArray[Any]) -> None:
        """Append an array (rows,) to a column.

        Raises
        ------
        OSError
            The file cannot be written, for instance because the disk is full.
        """
        if self._file is None:
            self._file = tempfile.TemporaryFile()  # noqa: SIM115
            weakref.finalize(self, self._file.close)
        self._arrays.setdefault(name, []).append((self._file.tell(), array.nbytes, array.dtype))
        self._file.write(array.tobytes())

    def column(self, name: str) -> list[npt.NDArray[Any]]:
        """Return the arrays of a column; nothing for a column without any."""
        found = []
        for place, length, dtype in self._arrays.get(name, []):
            assert self._file is not None
            self._file.seek(place)
            found.append(np.frombuffer(self._file.read(length), dtype))
        return found


Schema = Mapping[str, type | tuple[str, ...]]
"""Dtype of each column by name, or the names of its categories in the order of their codes."""

VIEW_NAMES = tuple(VIEWS.get(view, view.name.lower()) for view in View)

TRUTH: Schema = {
    "actor_id": np.int64,
    "name": np.str_,
    "kind": tuple(kind.name.lower() for kind in Kind),
    "x_world_m": np.float64,
    "y_world_m": np.float64,
    "yaw_world_rad": np.float64,
    "length_m": np.float64,
    "width_m": np.float64,
    **dict.fromkeys(ARTICULATION, np.float64),
    "vx_world_mps": np.float64,
    "vy_world_mps": np.float64,
    "ax_world_mps2": np.float64,
    "ay_world_mps2": np.float64,
    "yaw_rate_radps": np.float64,
    "mode": MODELS,
    "deviation_along_m": np.float64,
    "deviation_across_m": np.float64,
    "changes_lane": np.bool_,
    "range_m": np.float64,
    "points": np.int64,
    "hits": np.int64,
    "hits_alone": np.int64,
    "visible_fraction": np.float64,
    "view": VIEW_NAMES,
    "graded": np.bool_,
    "vulnerable": np.bool_,
    "track_id": np.int64,
    "segments": np.int64,
    "largest_segment_share": np.float64,
}
"""A row per actor and frame. `segments` counts the segments with at least `part_share_min` of its points; the largest
share is NaN without a trace of the tracker. A `vulnerable` actor is a graded person or rider. `mode` is the true
`Mode`, by the name of the matching motion model."""


LABELS = ("vehicle", "small")
"""Classes that a tracker may give to its tracks."""


def model_columns(models: Iterable[str]) -> dict[str, type]:
    """Return the columns of the track table of some models and of the reported estimate."""
    ahead = (f"{label}_{axis}_world_m" for label, axis in product(HORIZONS, "xy"))
    of_estimate = (*(f"{axis}_error_m" for axis in "xy"), *(f"ahead_{name}" for name in ahead))
    names = [
        *(f"probability_{model}" for model in models),
        *(f"{estimate}_{name}" for estimate in estimates(models) for name in of_estimate),
        *(f"{model}_{measure}" for measure in ("nees", "nis") for model in models),
    ]
    return dict.fromkeys(names, np.float64)


def track_schema(models: Iterable[str]) -> Schema:
    """Return `TRACKS` with the columns of further models."""
    return {**TRACKS, **model_columns(models)}


def models_of(tracks: pd.DataFrame) -> tuple[str, ...]:
    """Return the models of a track table: the standard ones and those of its filter bank."""
    return tuple(model for model in MODEL_NAMES if model in MODELS or f"probability_{model}" in tracks)


TRACKS: Schema = {
    "track_id": np.int64,
    "status": tuple(status.name.lower() for status in Status),
    "x_world_m": np.float64,
    "y_world_m": np.float64,
    "yaw_world_rad": np.float64,
    "length_m": np.float64,
    "width_m": np.float64,
    "range_m": np.float64,
    "vx_world_mps": np.float64,
    "vy_world_mps": np.float64,
    "ax_world_mps2": np.float64,
    "ay_world_mps2": np.float64,
    "model": MODEL_NAMES,
    "verdict": tuple(verdict.name.lower() for verdict in TrackVerdict),
    "actor_id": np.int64,
    "true_mode": MODELS,
    "iou": np.float64,
    "heading_error_deg": np.float64,
    "judged": np.bool_,
    "label": LABELS,
    "corner_along": np.float64,
    "corner_across": np.float64,
    "nees": np.float64,
    **model_columns(MODELS),
}
"""A row per track and frame: pose of the box centre, velocity and acceleration of the tracked corner. The actor's
`true_mode` (the name of the matching standard model), overlap and heading error are NaN for a track that follows no
actor. Its `label` is NaN for a tracker without
classes. A track is `judged` when it is confirmed and on a graded vehicle. For other tracks the signs of the tracked
corner in the frame of the true box, the corner errors (ego axes), the predicted corners, the NEES, and the NEES and NIS
of each model are NaN. A bank with other models has further columns of `model_columns`."""

EGO: Schema = {
    "x_world_m": np.float64,
    "y_world_m": np.float64,
    "yaw_world_rad": np.float64,
    "length_m": np.float64,
    "width_m": np.float64,
    "vx_world_mps": np.float64,
    "vy_world_mps": np.float64,
}
"""A row per frame: pose and size of the ego's box, and the velocity of its centre."""

OVERLAPS: Schema = {"actor_id": np.int64, "track_id": np.int64, "iou": np.float64}
"""Every overlap of an actor with a reported track."""

FITS: Schema = {
    "segment": np.int64,
    "actor_id": np.int64,
    "view": VIEW_NAMES,
    "range_m": np.float64,
    "points": np.int64,
    "heading_bound_deg": np.float64,
    "seen_length_m": np.float64,
    "seen_width_m": np.float64,
    "box_heading_ego_rad": np.float64,
    "box_heading_std_deg": np.float64,
    "method": CANDIDATES,
    "cost": np.float64,
    "best": np.bool_,
    "x_ego_m": np.float64,
    "y_ego_m": np.float64,
    "heading_ego_rad": np.float64,
    "length_m": np.float64,
    "width_m": np.float64,
    "true_x_ego_m": np.float64,
    "true_y_ego_m": np.float64,
    "true_yaw_ego_rad": np.float64,
    "true_length_m": np.float64,
    "true_width_m": np.float64,
}
"""A row per fit observation and candidate; the candidates of one observation are consecutive. A method without a fit
has a NaN rectangle, a baseline without a fit has no row. Bound, visible extents and the box of the selected rectangle
are those of the observation, NaN without one. `fit_errors.measure` adds the errors and `oracle`."""

SEGMENTS: Schema = {
    "segment": np.int64,
    "points": np.int64,
    "actor_id": np.int64,
    "share": np.float64,
    "second_share": np.float64,
}
"""A row per segment in which a graded vehicle has at least `part_share_min` of the points: the actor with most
points, its share, and the second largest share."""

OUTLIERS: Schema = {
    "cause": tuple(cause.name.lower() for cause in Cause),
    "points": np.int64,
    "removed": np.int64,
    "clean_removed_beside": np.int64,
}
"""A row per cause: points in the segments of graded vehicles, the number of them removed by T-linkage, and the number
of clean points removed in segments with points of this cause."""

BLOCKERS: Schema = {"actor_id": np.int64, "blocker_id": np.int64, "points": np.int64}
"""A row per hidden vehicle, frame and blocker: points on what the beams hit instead, see `occlusions.BlockerLog`."""

EXTREMES: Schema = {
    "acceleration_max_mps2": np.float64,
    "jerk_max_mps3": np.float64,
    "overlap_max_m2": np.float64,
    "masked": np.int64,
}
"""A row per frame: the largest acceleration, jerk and overlap of all bodies, and the number of vehicles that are not
graded because of truth events, see `truth_events.event_log`."""

SCHEMAS: Mapping[str, Schema] = {
    "truth": TRUTH,
    "tracks": TRACKS,
    "overlaps": OVERLAPS,
    "fits": FITS,
    "segments": SEGMENTS,
    "outliers": OUTLIERS,
}
"""Schema of every table by name."""


SNAPSHOT_KINDS = ("detection", "identity", "track_heading", "fit_heading")
"""Kinds of errors for which frames are kept."""

SNAPSHOTS: Schema = {
    "kind": SNAPSHOT_KINDS,
    "badness": np.float64,
    "what": np.str_,
    "x_ego_m": np.float64,
    "y_ego_m": np.float64,
    "ego_x_world_m": np.float64,
    "ego_y_world_m": np.float64,
    "ego_yaw_world_rad": np.float64,
    "ego_length_m": np.float64,
    "ego_width_m": np.float64,
}
"""A row per kept frame, one of the worst of its kind: size, description and position of the error."""

SNAPSHOT_POINTS: Schema = {
    "x_ego_m": np.float32,
    "y_ego_m": np.float32,
    "actor_id": np.int64,
    "cause": tuple(cause.name.lower() for cause in Cause),
}
"""A row per scan point of the kept frames."""


@cache
def _category(names: tuple[str, ...]) -> pd.CategoricalDtype:
    """Return the type of a column of categories, whose names are checked once."""
    return pd.CategoricalDtype(list(names))


CHUNK_FRAMES = 256
"""Frames whose rows are copied together into one array per column: thousands of small arrays take twice the memory."""


class TableBuilder:
    """Collects the rows of one table frame by frame, in memory those of the last `CHUNK_FRAMES` only.

    Parameters
    ----------
    schema
        Columns of the table, without `frame` and `time_s`.
    """

    def __init__(self, schema: Schema) -> None:
        self._schema = schema
        self._spool = ColumnSpool()
        self._parts: list[Mapping[str, npt.NDArray[Any]]] = []
        self._frames: list[int] = []
        self._times: list[float] = []
        self._rows: list[int] = []

    def add(self, frame: WorldFrame, columns: Mapping[str, npt.NDArray[Any]]) -> None:
        """Append the rows of one frame.

        Parameters
        ----------
        columns
            An array (rows,) per column of the schema; enumerations as codes.

        Raises
        ------
        ValueError
            A column is missing or not in the schema.
        """
        if columns.keys() != self._schema.keys():
            raise ValueError(f"columns {sorted(columns.keys() ^ self._schema.keys())} are missing or not in the schema")
        self._parts.append(columns)
        self._frames.append(frame.index)
        self._times.append(frame.time)
        self._rows.append(len(next(iter(columns.values()))))
        if len(self._rows) == CHUNK_FRAMES:
            self._spool_chunk()

    def _spool_chunk(self) -> None:
        """Move the rows of the last frames to the spool, as one array per column."""
        for name, array in self._chunk().items():
            self._spool.append(name, array)
        self._frames, self._times, self._rows, self._parts = [], [], [], []

    def _chunk(self) -> dict[str, npt.NDArray[Any]]:
        """Return the rows of the last frames: an array per column, of the type of the column."""
        columns: dict[str, npt.NDArray[Any]] = {
            "frame": np.repeat(np.array(self._frames, dtype=np.int64), self._rows),
            "time_s": np.repeat(np.array(self._times, dtype=np.float64), self._rows),
        }
        for name, kind in self._schema.items():
            parts, stored = [part[name] for part in self._parts], np.int8 if isinstance(kind, tuple) else kind
            columns[name] = np.concatenate(parts).astype(stored) if parts else np.empty(0, stored)
        return columns

    def build(self) -> pd.DataFrame:
        """Return all rows as a data frame; a table without rows keeps its columns and their types."""
        columns: dict[str, Any] = {}
        for name, last in self._chunk().items():
            values, kind = np.concatenate([*self._spool.column(name), last]), self._schema.get(name)
            columns[name] = (
                pd.Categorical.from_codes(values, dtype=_category(kind)) if isinstance(kind, tuple) else values
            )
        return pd.DataFrame(columns, copy=False)


def columns_of(table: pd.DataFrame, names: Iterable[str]) -> Floats:
    """(n, columns) values of some columns; several times as fast as `table[[...]]`, which makes an index of texts."""
    return np.column_stack([np.asarray(table[name], dtype=np.float64) for name in names])


def rows_of_pairs(frame: Ints, number: Ints, of_frame: Ints, of_number: Ints) -> Ints:
    """(n,) row at which each pair of frame and id is first among other pairs (m,), -1 for none.

    Parameters
    ----------
    frame, number
        (n,) pairs to find.
    of_frame, of_number
        (m,) pairs among which they are looked for.
    """
    if not len(of_frame):
        return np.full(len(frame), -1)
    numbers, code = np.unique(np.concatenate([number, of_number]), return_inverse=True)
    wanted, known = frame * len(numbers) + code[: len(frame)], of_frame * len(numbers) + code[len(frame) :]
    order = np.argsort(known, kind="stable")
    row = order[np.minimum(np.searchsorted(known, wanted, sorter=order), len(known) - 1)]
    return np.where(known[row] == wanted, row, -1)


def rows_by_actor(actor_id: Ints, rows: Ints) -> Iterator[tuple[int, Ints]]:
    """Yield the id of each actor in ascending order, and its rows.

    Parameters
    ----------
    actor_id
        (N,) id of the actor of each row of a table.
    rows
        (K,) rows to divide, whose order is kept.
    """
    order = np.argsort(actor_id[rows], kind="stable")
    ids, starts = np.unique(actor_id[rows][order], return_index=True)
    parts = np.split(rows[order], starts[1:]) if len(ids) else []
    yield from zip(ids.tolist(), parts, strict=True)

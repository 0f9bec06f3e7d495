"""Boxes of a file in one common record, the same for every format."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import TracksError

Texts = npt.NDArray[np.str_]

EGO_AXES = ("ego", "camera")
"""Axes whose origin is the ego or its sensor."""
IMAGE_AXES = "image"
"""Axes of boxes in the image of KITTI's camera: x right, y down, all in pixels, no headings."""
ANY_AXES = ""
"""Axes of a file that does not name them: they are taken for those of the other file."""
BOX = ("x", "y", "heading", "length", "width")
LARGEST = 1e7
"""Absolute value of any number, in m, rad or m/s."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxTable:
    """N boxes of all frames of a file, each with the id of its object or track."""

    source: Path
    axes: str
    """Frame of reference of the positions, such as "world", "odom" or "ego"; `ANY_AXES` if the file does not say."""
    id: Texts
    """(N,) id of the object or track, the same in all frames."""
    boxes: Floats
    """(N, 5) x [m], y [m], heading [rad] counter-clockwise from x, length [m], width [m], about the centre."""
    frame: Ints | None = None
    """(N,) number of the frame; a file has one of `frame`, `time_s` and `sample`, or several of them."""
    time_s: Floats | None = None
    """(N,) time [s]."""
    sample: Texts | None = None
    """(N,) name of the sample (keyframe)."""
    scene: Texts | None = None
    """(N,) name of the scene or sequence, each with frames and ids of its own; None for one."""
    scene_of: Mapping[str, str] = field(default_factory=dict)
    """Scene of every sample, in the order of time; samples without boxes are in it, too."""
    velocity: Floats | None = None
    """(N, 2) velocity over ground on the same axes [m/s], NaN where it is unknown; None if the format has none."""
    z_m: Floats | None = None
    """(N,) height of the centre [m]."""
    height_m: Floats | None = None
    """(N,) height of the box [m]."""
    score: Floats | None = None
    """(N,) confidence; more is surer."""
    points: Ints | None = None
    """(N,) number of LIDAR points on the box; only of truth."""
    occluded: Ints | None = None
    """(N,) level of occlusion of KITTI, 0 to 3; only of truth."""
    truncated: Ints | None = None
    """(N,) level of truncation of KITTI, 0 to 2; only of truth."""
    kind: Texts | None = None
    """(N,) name of the class, in lower case."""

    def __len__(self) -> int:
        return len(self.id)

    def select(self, rows: Bools | Ints) -> "BoxTable":
        """Return the boxes of a mask (N,), or of row numbers in their order."""
        values: dict[str, Any] = {name: getattr(self, name) for name in (*COLUMNS, "scene")}
        kept: dict[str, Any] = {name: None if column is None else column[rows] for name, column in values.items()}
        return replace(self, **kept)


COLUMNS = (
    "id", "boxes", "frame", "time_s", "sample", "velocity", "z_m", "height_m", "score", "points", "occluded",
    "truncated", "kind",
)  # fmt: skip
"""Columns of a table without its scene."""


def joined(source: Path, tables: Mapping[str, BoxTable]) -> BoxTable:
    """Return the boxes of several scenes by their names; columns that one of them lacks are left out."""
    parts = list(tables.values())
    columns: dict[str, Any] = {
        name: None
        if any(getattr(part, name) is None for part in parts)
        else np.concatenate([getattr(part, name) for part in parts])
        for name in COLUMNS
    }
    scene = np.concatenate([np.full(len(part), name) for name, part in tables.items()])
    return replace(parts[0], source=source, scene=scene, **columns)


def checked(table: BoxTable, place: Callable[[int], str]) -> BoxTable:
    """Return a table whose numbers are finite, whose sizes are positive, and whose ids are unique in a frame.

    Parameters
    ----------
    table
        The table.
    place
        Function that names the place of a row in the file, such as "line 3".

    Raises
    ------
    TracksError
        A row is not valid; the message names its place, the value and the remedy.
    """
    for column, name in enumerate(BOX):
        _require(table, place, name, table.boxes[:, column], _plausible(table.boxes[:, column]), "should be a number")
    for column in (3, 4):
        values = table.boxes[:, column]
        _require(table, place, BOX[column], values, values > 0.0, "should be more than 0")
    for name in ("time_s", "z_m", "score"):
        values = getattr(table, name)
        if values is not None:
            limit = np.inf if name == "time_s" else LARGEST
            _require(table, place, name, values, _plausible(values, limit), "should be a number")
    if table.height_m is not None:
        _require(table, place, "height", table.height_m, table.height_m > 0.0, "should be more than 0")
    if table.velocity is not None:
        speed = np.hypot(*table.velocity.T)
        _require(table, place, "velocity", speed, _plausible(speed) | np.isnan(speed), "should be two numbers")
    _refuse_duplicates(table, place)
    return table


def is_count(text: str) -> bool:
    """Return True for a number of points in text, of up to nine digits."""
    return text.isascii() and text.isdecimal() and len(text) < 10


def lower_classes(source: Path, key: str, names: Texts, known: Iterable[str], place: Callable[[int], str]) -> Texts:
    """Return names of classes (N,) in lower case.

    Parameters
    ----------
    source, place
        The file, and the place of a row as for `checked`.
    key
        Name of the class in the format.
    names
        Names as written, in any case.
    known
        All names that the format has.

    Raises
    ------
    TracksError
        A name is none of the known ones.
    """
    choice = list(dict.fromkeys(known))
    lower = np.char.lower(names)
    valid = np.isin(lower, [name.lower() for name in choice])
    if not valid.all():
        row = int(np.argmin(valid))
        raise TracksError(f"{source}: {place(row)}, {key}: {names[row]:.60}: should be one of {', '.join(choice)}")
    return lower


def _plausible(values: Floats, largest: float = LARGEST) -> Bools:
    return np.isfinite(values) & (np.abs(values) <= largest)


def _require(
    table: BoxTable, place: Callable[[int], str], name: str, values: Floats, valid: Bools, remedy: str
) -> None:
    if not valid.all():
        row = int(np.argmin(valid))
        raise TracksError(f"{table.source}: {place(row)}, {name}: {values[row]:g}: {remedy}")


def _refuse_duplicates(table: BoxTable, place: Callable[[int], str]) -> None:
    keys = {name: getattr(table, name) for name in ("sample", "frame", "time_s") if getattr(table, name) is not None}
    name, when = next(iter(keys.items()))
    scene = "" if table.scene is None else table.scene
    again = pd.DataFrame({"scene": scene, "when": when, "id": table.id}).duplicated().to_numpy(np.bool_)
    if again.any():
        row = int(np.argmax(again))
        raise TracksError(
            f"{table.source}: {place(row)}, id: {table.id[row]}: occurs twice in {name} {when[row]}; "
            "give each id one box per frame"
        )

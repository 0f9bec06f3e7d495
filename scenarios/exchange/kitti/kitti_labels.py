"""Reader of KITTI tracking labels and results (`label_02`), one text file per sequence.

Each line has 17 fields, results an 18th: frame, track id, type, truncated, occluded, alpha, 2D box (4), height, width,
length [m], x, y, z [m] of the bottom centre in camera axes, rotation_y [rad], score (Geiger et al. 2012, development
kit of the tracking benchmark). Camera axes are x right, y down, z forward.

The ground plane is turned into x forward, y left: (z, -x). A box with rotation_y = 0 faces along the camera's x axis,
and rotation_y turns clockwise seen from above, so the heading is -rotation_y - pi / 2.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import IMAGE_AXES, BoxTable, Texts, checked, joined, lower_classes
from luxloop.scenarios.exchange.file_formats import Role

LABELS = ("training/label_02", "label_02", ".")
"""Places of the labels, from the root of a data set, from its part `training`, and in the folder of labels itself."""
RESULTS = "results"
"""Folder of the tracks in exports of luxloop."""
SEQUENCE = "[0-9]*.txt"
"""Names of the files, which are numbers of sequences."""


def is_kitti(folder: Path) -> bool:
    """Return True for a folder with labels or results of sequences."""
    return any(_sequences(folder / place) for place in (*LABELS, RESULTS))


def sequences(folder: Path, role: Role) -> list[Path]:
    """Return the files of labels, or of the results for tracks, one for each sequence.

    Raises
    ------
    TracksError
        The folder has none.
    """
    places = LABELS if role == "truth" else (RESULTS, ".")
    found = next((files for place in places if (files := _sequences(folder / place))), [])
    if not found:
        wanted = LABELS[0] if role == "truth" else RESULTS
        raise TracksError(f"{folder}: no {wanted}/0000.txt in it; give the text file of a sequence")
    return found


def read_boxes(path: Path, role: Role) -> list[BoxTable]:
    """Return the boxes of a file, or of all sequences of a folder, of which each of several is a scene.

    They are in camera axes and, where every line has such a box, in the image. Files of trackers in the image have
    only these.

    Raises
    ------
    TracksError
        There is no file, or one is invalid.
    """
    files = sequences(path, role) if path.is_dir() else [path]
    labels = {file.stem: Labels.of(file) for file in files}
    sizes = [each.values[name] for each in labels.values() for name in ("height", "width", "length")]
    flat = role == "tracks" and all((size <= 0.0).all() for size in sizes)  # results of the image have -1
    flat = flat and any(len(each.place) for each in labels.values())
    in_image = all((each.image_boxes()[:, 3:] > 0.0).all() for each in labels.values())
    makers = [] if flat and in_image else [Labels.on_the_ground]
    makers += [Labels.in_the_image] if in_image else []
    tables = [{name: make(each) for name, each in labels.items()} for make in makers]
    return [joined(path, of_axes) if len(files) > 1 else next(iter(of_axes.values())) for of_axes in tables]


def _sequences(folder: Path) -> list[Path]:
    return sorted(folder.glob(SEQUENCE)) if folder.is_dir() else []


FIELDS = (
    "frame", "track_id", "type", "truncated", "occluded", "alpha", "left", "top", "right", "bottom",
    "height", "width", "length", "x", "y", "z", "rotation_y", "score",
)  # fmt: skip
NUMBERS = tuple(name for name in FIELDS if name not in ("track_id", "type"))
TYPES = ("Car", "Van", "Truck", "Pedestrian", "Person", "Person_sitting", "Cyclist", "Tram", "Misc")
IGNORED = "dontcare"
"""Type of regions of the image without labels; they have no box on the ground."""


def read(path: Path) -> BoxTable:
    """Return the boxes of a file of labels or results in camera axes.

    Raises
    ------
    TracksError
        The file cannot be read, or a line is invalid.
    """
    return Labels.of(path).on_the_ground()


class Labels(NamedTuple):
    """Lines of a file."""

    path: Path
    place: Ints
    """(N,) numbers of the lines."""
    id: Texts
    kind: Texts
    """(N,) types in lower case."""
    values: dict[str, Floats]
    """(N,) by the names of `NUMBERS`."""

    @classmethod
    def of(cls, path: Path) -> "Labels":
        """Read a file; errors as of `read`."""
        rows = _lines(path)
        place = [number for number, _ in rows]
        values = {
            name: np.array([_number(path, number, name, words[at]) for number, words in rows], np.float64)
            for at, name in enumerate(FIELDS)
            if name in NUMBERS and (name != "score" or (rows and len(rows[0][1]) == len(FIELDS)))
        }
        types = np.array([words[2] for _, words in rows], dtype=np.str_)
        kind = lower_classes(path, "type", types, (*TYPES, "DontCare"), lambda row: f"line {place[row]}")
        return cls(
            path, np.array(place, np.int64), np.array([words[1] for _, words in rows], dtype=np.str_), kind, values
        )

    def on_the_ground(self) -> BoxTable:
        """Return the boxes in camera axes, without regions."""
        labels = self._select(self.kind != IGNORED)
        values = labels.values
        table = BoxTable(
            axes="camera",
            boxes=_boxes(values),
            z_m=0.5 * values["height"] - values["y"],
            height_m=values["height"],
            **labels._columns(),
        )
        return checked(table, labels._line)

    def in_the_image(self) -> BoxTable:
        """Return the boxes in the image, and the regions; boxes with negative ids are left out, as in the benchmark."""
        region = self.kind == IGNORED
        labels = self._select(region | ~np.char.startswith(self.id, "-"))
        columns = labels._columns()
        numbered = np.char.add("region of line ", labels.place.astype(np.str_))
        columns["id"] = np.where(labels.kind == IGNORED, numbered, labels.id)
        table = BoxTable(
            axes=IMAGE_AXES,
            boxes=labels.image_boxes(),
            truncated=np.trunc(labels.values["truncated"]).astype(np.int64),
            **columns,
        )
        return checked(table, labels._line)

    def image_boxes(self) -> Floats:
        """(N, 5) centre, heading 0, width and height in the image [pixels]."""
        left, top, right, bottom = (self.values[name] for name in ("left", "top", "right", "bottom"))
        return np.column_stack(
            [0.5 * (left + right), 0.5 * (top + bottom), np.zeros(len(left)), right - left, bottom - top]
        )

    def _columns(self) -> dict[str, Any]:
        """Return the columns that all axes have."""
        return {
            "source": self.path,
            "frame": self._integers("frame"),
            "id": self.id,
            "score": self.values.get("score"),
            "occluded": self._integers("occluded"),
            "kind": self.kind,
        }

    def _integers(self, name: str) -> Ints:
        values = self.values[name]
        valid = (values == np.rint(values)) & (np.abs(values) < 2**53)
        if not valid.all():
            row = int(np.argmin(valid))
            raise TracksError(f"{self.path}: {self._line(row)}, {name}: {values[row]:g}: should be an integer")
        return values.astype(np.int64)

    def _select(self, rows: Bools) -> "Labels":
        values = {name: column[rows] for name, column in self.values.items()}
        return Labels(self.path, self.place[rows], self.id[rows], self.kind[rows], values)

    def _line(self, row: int) -> str:
        return f"line {self.place[row]}"


def heading(rotation_y: Floats) -> Floats:
    """Return headings [rad] of rotations about the camera's y axis, or these rotations of headings."""
    turned: Floats = -rotation_y - 0.5 * np.pi
    return turned - 2.0 * np.pi * np.ceil(turned / (2.0 * np.pi) - 0.5)


def _boxes(values: dict[str, Floats]) -> Floats:
    x, y = values["z"], -values["x"]
    return np.column_stack([x, y, heading(values["rotation_y"]), values["length"], values["width"]])


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """Return number and words of every line; all lines have as many."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise TracksError(f"{path}: cannot be read ({reason}); give a KITTI text file of labels") from error
    lines = [(number, line.split()) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    for number, words in lines:
        if len(words) not in (len(FIELDS) - 1, len(FIELDS)):
            raise TracksError(
                f"{path}: line {number}: {len(words)} fields; KITTI tracking has {len(FIELDS) - 1}, and results "
                f"{len(FIELDS)} with the score"
            )
    scored = [number for number, words in lines if len(words) == len(FIELDS)]
    if scored and len(scored) < len(lines):
        raise TracksError(f"{path}: line {scored[0]}: score: only some lines have one; give it in all lines or in none")
    return lines


def _number(path: Path, line: int, name: str, word: str) -> float:
    try:
        return float(word)
    except ValueError as error:
        raise TracksError(f"{path}: line {line}, {name}: {word[:60]}: should be a number") from error

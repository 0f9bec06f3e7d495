"""Reader of KITTI tracking labels and results (`label_02`), one text file per sequence.

Each line has 17 fields, results an 18th: frame, track id, type, truncated, occluded, alpha, 2D box (4), height, width,
length [m], x, y, z [m] of the bottom centre in camera axes, rotation_y [rad], score (Geiger et al. 2012, development
kit of the tracking benchmark). Camera axes are x right, y down, z forward.

The ground plane is turned into x forward, y left: (z, -x). A box with rotation_y = 0 faces along the camera's x axis,
and rotation_y turns clockwise seen from above, so the heading is -rotation_y - pi / 2.
"""

from pathlib import Path

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import BoxTable, checked, joined, lower_classes
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


def read_folder(folder: Path, role: Role) -> BoxTable:
    """Return the boxes of all sequences of a folder; of several, each is a scene.

    Raises
    ------
    TracksError
        There is none, or a file is invalid.
    """
    files = sequences(folder, role)
    return joined(folder, {file.stem: read(file) for file in files}) if len(files) > 1 else read(files[0])


def _sequences(folder: Path) -> list[Path]:
    return sorted(folder.glob(SEQUENCE)) if folder.is_dir() else []


FIELDS = (
    "frame", "track_id", "type", "truncated", "occluded", "alpha", "left", "top", "right", "bottom",
    "height", "width", "length", "x", "y", "z", "rotation_y", "score",
)  # fmt: skip
NUMBERS = tuple(name for name in FIELDS if name not in ("track_id", "type"))
TYPES = ("Car", "Van", "Truck", "Pedestrian", "Person", "Person_sitting", "Cyclist", "Tram", "Misc")
IGNORED = "dontcare"
"""Type of regions without labels; they have no 3D box and are not read."""


def read(path: Path) -> BoxTable:
    """Return the boxes of a file of labels or results.

    Raises
    ------
    TracksError
        The file cannot be read, or a line is invalid.
    """
    lines = _lines(path)
    rows = [(number, words) for number, words in lines if words[2].lower() != IGNORED]
    place = [number for number, _ in rows]
    values = {name: np.empty(len(rows)) for name in NUMBERS}
    for row, (number, words) in enumerate(rows):
        for name, word in zip(FIELDS, words, strict=False):
            if name in values:
                values[name][row] = _number(path, number, name, word)

    def line(row: int) -> str:
        return f"line {place[row]}"

    frame = _integers(path, place, "frame", values["frame"])
    types = np.array([words[2] for _, words in rows], dtype=np.str_)
    scored = bool(rows) and len(rows[0][1]) == len(FIELDS)
    table = BoxTable(
        source=path,
        axes="camera",
        frame=frame,
        id=np.array([words[1] for _, words in rows], dtype=np.str_),
        boxes=_boxes(values),
        z_m=0.5 * values["height"] - values["y"],
        height_m=values["height"],
        score=values["score"] if scored else None,
        occluded=_integers(path, place, "occluded", values["occluded"]),
        kind=lower_classes(path, "type", types, TYPES, line),
    )
    return checked(table, line)


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


def _integers(path: Path, place: list[int], name: str, values: Floats) -> Ints:
    valid = (values == np.rint(values)) & (np.abs(values) < 2**53)
    if not valid.all():
        row = int(np.argmin(valid))
        raise TracksError(f"{path}: line {place[row]}, {name}: {values[row]:g}: should be an integer")
    return values.astype(np.int64)

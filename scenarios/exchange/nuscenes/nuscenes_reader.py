"""Reader of nuScenes: tracking results, or the true boxes of a folder of tables, from JSON.

Results have the format of the tracking task (Caesar et al. 2020, nuScenes; README of its tracking evaluation):
`results` maps each sample token to a list of boxes with `translation` (x, y, z of the centre [m]), `size` (width,
length, height [m]), `rotation` (quaternion w, x, y, z), `velocity` (vx, vy [m/s]), `tracking_id`, `tracking_name` and
`tracking_score`. A file of truth has the same structure and needs no scores. Samples are in the order of time.

The schema of the tables is that of docs/schema_nuscenes.md in the development kit. The velocity of an annotation is the
difference of the positions of the annotations before and after it over their time, as the development kit estimates
it, and unknown if they are too far apart in time. T4 data sets have the same tables in the folder `annotation`, with
the velocity in each row. Every error is one line with the place and the remedy.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import LARGEST, BoxTable, Texts, checked, lower_classes

Row = dict[str, Any]

CLASSES = {
    "vehicle.bicycle": "bicycle", "vehicle.bus.bendy": "bus", "vehicle.bus.rigid": "bus", "vehicle.car": "car",
    "vehicle.motorcycle": "motorcycle", "human.pedestrian.adult": "pedestrian", "human.pedestrian.child": "pedestrian",
    "human.pedestrian.construction_worker": "pedestrian", "human.pedestrian.police_officer": "pedestrian",
    "vehicle.trailer": "trailer", "vehicle.truck": "truck",
    **{name: name for name in ("bicycle", "bus", "car", "motorcycle", "pedestrian", "trailer", "truck")},
}  # fmt: skip
"""Classes of the tracking task by category, from the README of its evaluation, and by the categories of T4 data sets;
all other categories are ignored."""


def read_json(path: Path) -> Any:
    """Return the content of a file.

    Raises
    ------
    TracksError
        The file cannot be read, or is no JSON.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise TracksError(f"{path}: cannot be read ({reason}); give a nuScenes file in JSON") from error


def value(path: Path, place: str, row: Any, key: str) -> Any:
    """Return a value of a row.

    Raises
    ------
    TracksError
        The row is no object, or lacks the key.
    """
    if not isinstance(row, dict) or key not in row:
        raise TracksError(f"{path}: {place}: no key {key}; add it; see docs/formats.md")
    return row[key]


def text(path: Path, place: str, row: Any, key: str) -> str:
    """Return a text of a row; an integer is an id, too.

    Raises
    ------
    TracksError
        The value is neither.
    """
    found = value(path, place, row, key)
    if isinstance(found, bool) or not isinstance(found, str | int):
        raise TracksError(f"{path}: {place}, {key}: {str(found)[:60]}: should be a text")
    return str(found)


def number_list(path: Path, place: str, row: Any, key: str, count: int) -> Floats:
    """Return a list of `count` numbers of a row, which may be NaN.

    Raises
    ------
    TracksError
        The value is no such list.
    """
    found = value(path, place, row, key)
    good = isinstance(found, list) and len(found) == count and all(_is_number(item) for item in found)
    if not good:
        raise TracksError(f"{path}: {place}, {key}: {str(found)[:60]}: should be a list of {count} numbers")
    return np.array(found, dtype=np.float64)


def number(path: Path, place: str, row: Any, key: str) -> float:
    """Return a number of a row.

    Raises
    ------
    TracksError
        The value is no number.
    """
    found = value(path, place, row, key)
    if not _is_number(found):
        raise TracksError(f"{path}: {place}, {key}: {str(found)[:60]}: should be a number")
    return float(found)


def _is_number(found: Any) -> bool:
    """Return True for a number of a usual size; integers of any length are valid JSON, and too large for a float."""
    return isinstance(found, int | float) and not isinstance(found, bool) and not abs(found) > 1e300


GLOBAL = "global"
"""Name of the axes of nuScenes: global coordinates of the map."""


class Solid(NamedTuple):
    """Box in space."""

    box: Floats
    """(5,) x, y, heading, length, width, as in `BoxTable.boxes`."""
    z_m: float
    height_m: float


def read_results(path: Path) -> BoxTable:
    """Return the boxes of a file of results.

    Raises
    ------
    TracksError
        The file cannot be read, or a box is invalid.
    """
    results = value(path, "file", read_json(path), "results")
    if not isinstance(results, dict):
        raise TracksError(f"{path}: results: {str(results)[:60]}: should map sample tokens to lists of boxes")
    samples = [(sample, box) for sample, boxes in results.items() for box in _listed(path, sample, boxes)]
    place = [f"sample {sample}, box {number}" for sample, (number, _) in samples]
    rows = [row for _, (_, row) in samples]
    solids = [solid(path, where, row) for where, row in zip(place, rows, strict=True)]
    key = "tracking_name"
    table = BoxTable(
        source=path,
        axes=GLOBAL,
        id=_texts(path, place, rows, "tracking_id"),
        boxes=np.array([found.box for found in solids]).reshape(-1, 5),
        sample=np.array([sample for sample, _ in samples], np.str_),
        scene_of=dict.fromkeys(results, ""),
        velocity=_velocity(path, place, rows),
        z_m=np.array([found.z_m for found in solids]),
        height_m=np.array([found.height_m for found in solids]),
        score=_score(path, place, rows),
        kind=lower_classes(path, key, _texts(path, place, rows, key), CLASSES.values(), place.__getitem__),
    )
    return checked(table, place.__getitem__)


def solid(path: Path, place: str, row: Any) -> Solid:
    """Return the box of a row with `translation`, `size` and `rotation`.

    Raises
    ------
    TracksError
        One of them is invalid.
    """
    center = number_list(path, place, row, "translation", 3)
    width, length, height = number_list(path, place, row, "size", 3).tolist()
    rotation = number_list(path, place, row, "rotation", 4)
    norm = float(np.linalg.norm(rotation))
    if not 0.5 < norm < 2.0:
        raise TracksError(f"{path}: {place}, rotation: norm {norm:g}: should be a quaternion of norm 1")
    return Solid(np.array([*center[:2], yaw(rotation / norm), length, width]), float(center[2]), height)


def yaw(rotation: Floats) -> float:
    """Return the heading [rad] of the x axis turned by a quaternion (4,) w, x, y, z of norm 1."""
    w, x, y, z = rotation.tolist()
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def _listed(path: Path, sample: str, boxes: Any) -> list[tuple[int, Any]]:
    """Return the boxes of a sample with their numbers from 1."""
    if not isinstance(boxes, list):
        raise TracksError(f"{path}: sample {sample}: {str(boxes)[:60]}: should be a list of boxes")
    return list(enumerate(boxes, 1))


def _texts(path: Path, place: list[str], rows: list[Any], key: str) -> Texts:
    return np.array([text(path, where, row, key) for where, row in zip(place, rows, strict=True)], np.str_)


def _velocity(path: Path, place: list[str], rows: list[Any]) -> Floats | None:
    """(N, 2) velocities, NaN where they are missing; None if no box has one."""
    if not any("velocity" in row for row in rows):
        return None
    unknown = np.full(2, np.nan)
    found = zip(place, rows, strict=True)
    return np.array([number_list(path, p, row, "velocity", 2) if "velocity" in row else unknown for p, row in found])


def _score(path: Path, place: list[str], rows: list[Any]) -> Floats | None:
    """(N,) scores; None if no box has one."""
    if not any("tracking_score" in row for row in rows):
        return None
    return np.array([number(path, where, row, "tracking_score") for where, row in zip(place, rows, strict=True)])


ANNOTATIONS = "sample_annotation.json"
LONGEST_S = 1.5
"""Largest time between annotations for a velocity [s], twice as much for those on both sides."""


def folder_of_tables(path: Path) -> Path | None:
    """Return the folder with the tables: `path` itself or its one version folder; None if there is none."""
    if (path / ANNOTATIONS).is_file():
        return path
    found = sorted(path.glob(f"*/{ANNOTATIONS}")) if path.is_dir() else []
    if len(found) > 1:
        raise TracksError(f"{path}: has several versions, {', '.join(p.parent.name for p in found)}; give one of them")
    return found[0].parent if found else None


def read_tables(path: Path) -> BoxTable:
    """Return the annotations of the tracking classes in a folder.

    Raises
    ------
    TracksError
        A table is missing, or a row is invalid or has a token that is in no table.
    """
    folder = folder_of_tables(path)
    if folder is None:
        raise TracksError(f"{path}: no {ANNOTATIONS} in it or in a folder below; give a nuScenes folder")
    file = folder / ANNOTATIONS
    names = ("sample", "sample_annotation", "instance", "category")
    tables = {name: read_table(folder / f"{name}.json") for name in names}
    samples = dict(sorted(tables["sample"].items(), key=lambda item: _order(folder / "sample.json", *item)))
    rows = tables["sample_annotation"]
    solids = {token: solid(file, f"annotation {token}", row) for token, row in rows.items()}
    linked = {name: _linked(file, rows, f"{name}_token", tables[name]) for name in ("sample", "instance")}
    categories = _linked(folder / "instance.json", tables["instance"], "category_token", tables["category"])
    kind = {
        instance: text(folder / "category.json", f"row {token}", tables["category"][token], "name")
        for instance, token in categories.items()
    }
    stamp = {token: number(folder / "sample.json", f"row {token}", row, "timestamp") for token, row in samples.items()}
    time_s = np.array([1e-6 * stamp[linked["sample"][token]] for token in rows])
    order = {token: index for index, token in enumerate(samples)}
    table = BoxTable(
        source=path,
        axes=GLOBAL,
        id=np.array(list(linked["instance"].values()), np.str_),
        boxes=np.array([found.box for found in solids.values()]).reshape(-1, 5),
        frame=np.array([order[linked["sample"][token]] for token in rows], np.int64),
        time_s=time_s,
        sample=np.array(list(linked["sample"].values()), np.str_),
        scene_of={token: str(row.get("scene_token", "")) for token, row in samples.items()},
        velocity=_annotation_velocity(file, rows, solids, dict(zip(rows, time_s.tolist(), strict=True))),
        z_m=np.array([found.z_m for found in solids.values()]),
        height_m=np.array([found.height_m for found in solids.values()]),
        points=_points(file, rows),
        kind=np.array([CLASSES.get(kind[instance], "") for instance in linked["instance"].values()], np.str_),
    )
    place = [f"annotation {token}" for token in rows]
    whole = checked(table, place.__getitem__)
    return whole.select(_tracked(whole))


def _points(path: Path, rows: Mapping[str, Row]) -> Ints | None:
    """(N,) numbers of LIDAR points; None if an annotation has none."""
    if not all("num_lidar_pts" in row for row in rows.values()):
        return None
    found = np.array([number(path, f"row {token}", row, "num_lidar_pts") for token, row in rows.items()], np.float64)
    return np.nan_to_num(found, posinf=0.0, neginf=0.0).clip(0.0, LARGEST).astype(np.int64)


def _tracked(table: BoxTable) -> Bools:
    """(N,) True for the classes of the tracking task."""
    kind = table.kind
    assert kind is not None
    return np.array([name != "" for name in kind.tolist()], np.bool_)


def read_table(path: Path) -> dict[str, Row]:
    """Return the rows of a table by token."""
    rows = read_json(path)
    if not isinstance(rows, list):
        raise TracksError(f"{path}: should be a list of rows; give a nuScenes table")
    return {text(path, f"row {index}", row, "token"): row for index, row in enumerate(rows, 1)}


def _order(path: Path, token: str, row: Row) -> tuple[str, float]:
    """Return the sorting key of a sample: scene, then time."""
    return text(path, f"row {token}", row, "scene_token"), number(path, f"row {token}", row, "timestamp")


def _linked(path: Path, rows: Mapping[str, Row], key: str, target: Mapping[str, Row]) -> dict[str, str]:
    """Return a foreign key of every row, which is a token of the table `target`."""
    found = {token: text(path, f"row {token}", row, key) for token, row in rows.items()}
    for token, link in found.items():
        if link not in target:
            raise TracksError(f"{path}: row {token}, {key}: {link[:60]}: is no token of the other table; correct it")
    return found


def _annotation_velocity(
    path: Path, rows: Mapping[str, Row], solids: Mapping[str, Solid], time_s: Mapping[str, float]
) -> Floats:
    """(N, 2) velocity of each annotation; NaN without its own and without neighbours in time."""
    found = np.full((len(rows), 2), np.nan)
    for index, (token, row) in enumerate(rows.items()):
        if row.get("velocity") is not None:
            found[index] = number_list(path, f"annotation {token}", row, "velocity", 3)[:2]
            continue
        before, after = (str(row.get(key) or "") for key in ("prev", "next"))
        first, last = (link if link in rows else token for link in (before, after))
        between = time_s[last] - time_s[first]
        longest = 2.0 * LONGEST_S if token not in (first, last) else LONGEST_S
        if 0.0 < between <= longest:
            found[index] = (solids[last].box[:2] - solids[first].box[:2]) / between
    return found

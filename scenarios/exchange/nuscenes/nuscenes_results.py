"""Reader of nuScenes tracking results: boxes by sample token, in JSON.

The format is that of the tracking task of nuScenes (Caesar et al. 2020, nuScenes; README of its tracking evaluation):
`results` maps each sample token to a list of boxes with `translation` (x, y, z of the centre [m]), `size` (width,
length, height [m]), `rotation` (quaternion w, x, y, z), `velocity` (vx, vy [m/s]), `tracking_id`, `tracking_name` and
`tracking_score`. A file of truth has the same structure and needs no scores. Samples are in the order of time.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import BoxTable, Texts, checked, lower_classes
from luxloop.scenarios.exchange.json_file import number, number_list, read_json, text, value
from luxloop.scenarios.exchange.nuscenes.nuscenes_names import CLASSES

GLOBAL = "global"
"""Name of the axes of nuScenes: global coordinates of the map."""


class Solid(NamedTuple):
    """Box in space."""

    box: Floats
    """(5,) x, y, heading, length, width, as in `BoxTable.boxes`."""
    z_m: float
    height_m: float


def read(path: Path) -> BoxTable:
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

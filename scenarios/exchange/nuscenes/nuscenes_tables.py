"""Reader of the true boxes of a nuScenes folder: its tables in JSON, linked by tokens.

The schema is that of nuScenes (Caesar et al. 2020; docs/schema_nuscenes.md of its development kit). The velocity of an
annotation is the difference of the positions of the annotations before and after it over their time, as the
development kit estimates it, and unknown if they are too far apart in time. T4 data sets have the same tables in the
folder `annotation`, with the velocity in each row.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import LARGEST, BoxTable, Texts, checked
from luxloop.scenarios.exchange.json_file import Row, number, number_list, read_json, text
from luxloop.scenarios.exchange.nuscenes.nuscenes_names import CLASSES
from luxloop.scenarios.exchange.nuscenes.nuscenes_results import GLOBAL, Solid, solid

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


def read(path: Path) -> BoxTable:
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
    tables = {name: _table(folder / f"{name}.json") for name in names}
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
        velocity=_velocity(file, rows, solids, dict(zip(rows, time_s.tolist(), strict=True))),
        z_m=np.array([found.z_m for found in solids.values()]),
        height_m=np.array([found.height_m for found in solids.values()]),
        points=_points(file, rows),
        kind=_texts([CLASSES.get(kind[instance], "") for instance in linked["instance"].values()]),
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


def _texts(values: list[str]) -> Texts:
    return np.array(values, np.str_)


def _table(path: Path) -> dict[str, Row]:
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


def _velocity(path: Path, rows: Mapping[str, Row], solids: Mapping[str, Solid], time_s: Mapping[str, float]) -> Floats:
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

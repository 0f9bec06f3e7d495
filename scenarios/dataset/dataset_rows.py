"""Conversion between the records of a frame and the rows of a data set, lossless in both directions."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from luxloop.arrays import Floats, Floats32
from luxloop.scenarios.dataset.dataset_columns import OBSTACLES, Values
from luxloop.scenarios.files.input_file import read_parquet
from luxloop.scenarios.grading.articulated import ARTICULATION
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.grading.plane_geometry import corner, into_frame, nearest_sign
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Actors, Ego, Obstacles, WorldFrame
from luxloop.tracker.scan import Scan

Columns = Mapping[str, str | tuple[str, ...]]
"""Column of each field of a record; several where the field is an array with as many columns."""

PLACE = ("x_ego_m", "y_ego_m", "z_ego_m")
POSE_EGO, NEAREST = ("x_ego_m", "y_ego_m", "heading_ego_rad"), ("corner_x_ego_m", "corner_y_ego_m")
BODY: Columns = {
    "velocity_world": ("vx_world_mps", "vy_world_mps"),
    "acceleration_world": ("ax_world_mps2", "ay_world_mps2"),
    "yaw_rate": "yaw_rate_radps",
    "size": ("length_m", "width_m", "height_m"),
    "changes_lane": "changes_lane",
    "deviation": ("deviation_along_m", "deviation_across_m"),
    "ground_z": "ground_z_m",
    "attitude": ("pitch_rad", "roll_rad"),
}
"""Fields of the ego and of actors."""
EGO: Columns = {
    "pose_world": ("ego_x_world_m", "ego_y_world_m", "ego_yaw_world_rad"),
    **{
        field: f"ego_{names}" if isinstance(names, str) else tuple(f"ego_{name}" for name in names)
        for field, names in BODY.items()
    },
}
ACTOR: Columns = {
    "id": "actor_id",
    "name": "name",
    "kind": "kind",
    "pose_world": ("x_world_m", "y_world_m", "heading_world_rad"),
    **BODY,
    "articulation": ARTICULATION[0],
    "further_articulation": ARTICULATION[1:],
    "mode": "mode",
    "reflectivity": "reflectivity",
}
ODOMETRY: Columns = {"ego_pose_odom": ("odom_x_m", "odom_y_m", "odom_yaw_rad")}
POINT: Columns = {
    "points_ego": PLACE,
    "time_offset": "time_offset_s",
    "unit": "unit",
    "layer": "layer",
    "echo": "echo",
    "echo_pulse_width": "echo_pulse_width_m",
    "flags": "flags",
}
POINT_TRUTH: Columns = {"actor_id": "actor_id", "part": "part", "cause": "cause", "true_range": "true_range_m"}
LOST: Columns = {"lost_unit": "unit", "lost_beam": "beam", "lost_cause": "cause"}


def columns_of(record: Any, columns: Columns) -> dict[str, Any]:
    """Return fields of a record as columns."""
    found: dict[str, Any] = {}
    for field, names in columns.items():
        value = getattr(record, field)
        found |= {names: value} if isinstance(names, str) else _named(names, value.T)
    return found


def fields_of(rows: Values, columns: Columns) -> dict[str, Any]:
    """Return columns as fields of a record: the inverse of `columns_of`."""
    return {field: _field(rows, names) for field, names in columns.items()}


def _field(rows: Values, names: str | tuple[str, ...]) -> npt.NDArray[Any]:
    """Return one or several columns as traffic and sensor give them: codes as uint8, names in the narrowest dtype."""
    if not isinstance(names, str):
        return np.stack([rows[name] for name in names], axis=1)
    values = rows[names]
    if values.dtype.kind == "U":
        return np.array(values.tolist(), dtype=np.str_)
    return values.astype(np.uint8) if values.dtype == np.int8 else values


def rows_of(frame: WorldFrame, scan: Scan, truth: ScanTruth, grade: FrameGrade) -> dict[str, Values]:
    """Return the rows of one frame, by file."""
    return {
        "scans": _scans(frame, scan),
        "points": _points(frame, scan, truth),
        "labels": _labels(frame, truth, grade),
        "hits": _hits(frame, truth),
        "losses": _losses(frame, truth),
    }


def records_of(
    rows: dict[str, Values],
    units: int,
    sweep_limits: Floats32 | None = None,
    unit_positions_ego: Floats | None = None,
) -> tuple[WorldFrame, Scan, ScanTruth]:
    """Return the records of the rows of one frame: the exact inverse of `rows_of`.

    Parameters
    ----------
    rows
        Rows of one frame, by file.
    units
        Number of LIDARs of the rig.
    sweep_limits
        Fields of view of its layers, see `Scan.sweep_limits`; the rows do not contain them.
    unit_positions_ego
        Positions of the units, see `Scan.unit_positions_ego`; the rows do not contain them.
    """
    scans, points, labels = rows["scans"], rows["points"], rows["labels"]
    frame = WorldFrame(
        int(scans["frame"][0]), float(scans["time_s"][0]), _ego(scans), Actors(**fields_of(labels, ACTOR))
    )
    scan = Scan(
        time=frame.time,
        ego_pose_odom=fields_of(scans, ODOMETRY)["ego_pose_odom"][0],
        sweep_limits=sweep_limits,
        unit_positions_ego=unit_positions_ego,
        **fields_of(points, POINT),
    )
    truth = ScanTruth(
        unit_hits=rows["hits"]["hits"].reshape(-1, units),
        unit_hits_alone=rows["hits"]["hits_alone"].reshape(-1, units),
        **fields_of(points, POINT_TRUTH),
        **fields_of(rows["losses"], LOST),
        **fields_of(labels, {"faces": "faces", "view": "view"}),
    )
    return frame, scan, truth


def _ego(scans: Values) -> Ego:
    fields = fields_of(scans, EGO)
    return Ego(**{name: values[0] if values.ndim > 1 else values[0].item() for name, values in fields.items()})


def _scans(frame: WorldFrame, scan: Scan) -> Values:
    row = {
        "frame": frame.index,
        "time_s": frame.time,
        **columns_of(frame.ego, EGO),
        **columns_of(scan, ODOMETRY),
        "points": len(scan),
    }
    return {name: np.array([value]) for name, value in row.items()}


def _points(frame: WorldFrame, scan: Scan, truth: ScanTruth) -> Values:
    number = {"frame": np.full(len(scan), frame.index)}
    return number | columns_of(scan, POINT) | columns_of(truth, POINT_TRUTH)


def _labels(frame: WorldFrame, truth: ScanTruth, grade: FrameGrade) -> Values:
    actors = frame.actors
    pose_ego = into_frame(actors.pose_world, frame.ego.pose_world)
    boxes_ego = np.column_stack([pose_ego, actors.size[:, :2]])
    sign = nearest_sign(boxes_ego)
    return {
        "frame": np.full(len(actors), frame.index),
        **columns_of(actors, ACTOR),
        "graded": grade.graded,
        **_named(POSE_EGO, pose_ego.T),
        **_named(NEAREST, corner(boxes_ego, sign).T),
        "corner_front": sign[:, 0] > 0,
        "corner_left": sign[:, 1] > 0,
        "view": truth.view,
        "faces": truth.faces,
        "points": grade.points,
        "visible_fraction": truth.visible_fraction,
    }


def _hits(frame: WorldFrame, truth: ScanTruth) -> Values:
    actors, units = truth.unit_hits.shape
    return {
        "frame": np.full(actors * units, frame.index),
        "actor_id": np.repeat(frame.actors.id, units),
        "unit": np.tile(np.arange(units), actors),
        "hits": truth.unit_hits.ravel(),
        "hits_alone": truth.unit_hits_alone.ravel(),
    }


def _losses(frame: WorldFrame, truth: ScanTruth) -> Values:
    return {"frame": np.full(len(truth.lost_unit), frame.index)} | columns_of(truth, LOST)


def _named(names: Iterable[str], values: Iterable[Any]) -> dict[str, Any]:
    return dict(zip(names, values, strict=True))


FILE = "obstacles.parquet"


def write(folder: Path, obstacles: Obstacles) -> None:
    """Write the file.

    Raises
    ------
    OSError
        It cannot be written.
    """
    obstacle = np.repeat(np.arange(len(obstacles)), np.diff(obstacles.offset))
    values = {
        "obstacle": obstacle,
        "x_world_m": obstacles.vertices_world[:, 0],
        "y_world_m": obstacles.vertices_world[:, 1],
        "base_m": obstacles.base[obstacle],
        "top_m": obstacles.height[obstacle],
        "reflectivity": obstacles.reflectivity[obstacle],
    }
    schema = pa.schema([column.field for column in OBSTACLES])
    arrays = [column.array(values[column.name]) for column in OBSTACLES]
    pq.write_table(pa.Table.from_arrays(arrays, schema=schema), folder / FILE, compression="zstd")


def read(folder: Path) -> Obstacles:
    """Return the obstacles: the exact inverse of `write`; none if the file does not exist.

    Raises
    ------
    OSError, ValueError, KeyError, pyarrow.ArrowException
        The file is damaged.
    """
    path = folder / FILE
    if not path.exists():
        return Obstacles.from_polygons([], [])
    table = read_parquet(path)
    rows = {column.name: column.values(table[column.name].combine_chunks()) for column in OBSTACLES}
    obstacle = rows["obstacle"]
    if len(obstacle) and (obstacle[0] != 0 or not np.isin(np.diff(obstacle), (0, 1)).all()):
        raise ValueError("column obstacle: should count from 0, without gaps")
    first = np.flatnonzero(np.diff(obstacle, prepend=-1))
    return Obstacles(
        vertices_world=np.column_stack([rows["x_world_m"], rows["y_world_m"]]),
        offset=np.append(first, len(obstacle)).astype(np.int64),
        base=rows["base_m"][first],
        height=rows["top_m"][first],
        reflectivity=rows["reflectivity"][first],
    )

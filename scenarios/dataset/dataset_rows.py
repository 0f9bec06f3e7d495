"""Conversion between the records of a frame and the rows of a data set, lossless in both directions."""

from collections.abc import Iterable
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

PLACE = ("x_ego_m", "y_ego_m", "z_ego_m")
POSE, POSE_EGO = ("x_world_m", "y_world_m", "heading_world_rad"), ("x_ego_m", "y_ego_m", "heading_ego_rad")
SIZE, NEAREST = ("length_m", "width_m", "height_m"), ("corner_x_ego_m", "corner_y_ego_m")
VELOCITY, ACCELERATION = ("vx_world_mps", "vy_world_mps"), ("ax_world_mps2", "ay_world_mps2")
DEVIATION = ("deviation_along_m", "deviation_across_m")
ATTITUDE = ("pitch_rad", "roll_rad")
EGO_POSE, ODOM_POSE = ("ego_x_world_m", "ego_y_world_m", "ego_yaw_world_rad"), ("odom_x_m", "odom_y_m", "odom_yaw_rad")
"""Groups of columns that are one array in the records."""


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
    frame = WorldFrame(int(scans["frame"][0]), float(scans["time_s"][0]), _ego(scans), _actors(labels))
    scan = Scan(
        time=frame.time,
        ego_pose_odom=_stack(scans, ODOM_POSE)[0],
        points_ego=_stack(points, PLACE),
        time_offset=points["time_offset_s"],
        unit=points["unit"],
        layer=points["layer"],
        echo=points["echo"],
        echo_pulse_width=points["echo_pulse_width_m"],
        flags=points["flags"],
        sweep_limits=sweep_limits,
        unit_positions_ego=unit_positions_ego,
    )
    truth = ScanTruth(
        actor_id=points["actor_id"],
        part=points["part"].astype(np.uint8),
        cause=points["cause"].astype(np.uint8),
        true_range=points["true_range_m"],
        lost_unit=rows["losses"]["unit"],
        lost_beam=rows["losses"]["beam"],
        lost_cause=rows["losses"]["cause"].astype(np.uint8),
        unit_hits=rows["hits"]["hits"].reshape(-1, units),
        unit_hits_alone=rows["hits"]["hits_alone"].reshape(-1, units),
        faces=labels["faces"],
        view=labels["view"].astype(np.uint8),
    )
    return frame, scan, truth


def _ego(scans: Values) -> Ego:
    def ego(*names: str) -> Floats:
        values: Floats = _stack(scans, tuple(f"ego_{name}" for name in names))[0]
        return values

    return Ego(
        pose_world=_stack(scans, EGO_POSE)[0],
        velocity_world=ego(*VELOCITY),
        acceleration_world=ego(*ACCELERATION),
        yaw_rate=float(scans["ego_yaw_rate_radps"][0]),
        size=ego(*SIZE),
        changes_lane=bool(scans["ego_changes_lane"][0]),
        deviation=ego(*DEVIATION),
        ground_z=float(scans["ego_ground_z_m"][0]),
        attitude=ego(*ATTITUDE),
    )


def _actors(labels: Values) -> Actors:
    return Actors(
        id=labels["actor_id"],
        # The narrowest dtype for these names, as traffic sources return it.
        name=np.array(labels["name"].tolist(), dtype=np.str_),
        kind=labels["kind"].astype(np.uint8),
        pose_world=_stack(labels, POSE),
        velocity_world=_stack(labels, VELOCITY),
        acceleration_world=_stack(labels, ACCELERATION),
        yaw_rate=labels["yaw_rate_radps"],
        articulation=labels["articulation_rad"],
        further_articulation=_stack(labels, ARTICULATION[1:]),
        mode=labels["mode"].astype(np.uint8),
        changes_lane=labels["changes_lane"],
        deviation=_stack(labels, DEVIATION),
        ground_z=labels["ground_z_m"],
        attitude=_stack(labels, ATTITUDE),
        size=_stack(labels, SIZE),
        reflectivity=labels["reflectivity"],
    )


def _scans(frame: WorldFrame, scan: Scan) -> Values:
    ego = frame.ego
    row = {
        "frame": frame.index,
        "time_s": frame.time,
        **_named(EGO_POSE, ego.pose_world),
        **_named([f"ego_{name}" for name in VELOCITY], ego.velocity_world),
        **_named([f"ego_{name}" for name in ACCELERATION], ego.acceleration_world),
        "ego_yaw_rate_radps": ego.yaw_rate,
        **_named([f"ego_{name}" for name in SIZE], ego.size),
        "ego_changes_lane": ego.changes_lane,
        **_named([f"ego_{name}" for name in DEVIATION], ego.deviation),
        "ego_ground_z_m": ego.ground_z,
        **_named([f"ego_{name}" for name in ATTITUDE], ego.attitude),
        **_named(ODOM_POSE, scan.ego_pose_odom),
        "points": len(scan),
    }
    return {name: np.array([value]) for name, value in row.items()}


def _points(frame: WorldFrame, scan: Scan, truth: ScanTruth) -> Values:
    return {
        "frame": np.full(len(scan), frame.index),
        **_named(PLACE, scan.points_ego.T),
        "time_offset_s": scan.time_offset,
        "unit": scan.unit,
        "layer": scan.layer,
        "echo": scan.echo,
        "echo_pulse_width_m": scan.echo_pulse_width,
        "flags": scan.flags,
        "actor_id": truth.actor_id,
        "part": truth.part,
        "cause": truth.cause,
        "true_range_m": truth.true_range,
    }


def _labels(frame: WorldFrame, truth: ScanTruth, grade: FrameGrade) -> Values:
    actors = frame.actors
    pose_ego = into_frame(actors.pose_world, frame.ego.pose_world)
    boxes_ego = np.column_stack([pose_ego, actors.size[:, :2]])
    sign = nearest_sign(boxes_ego)
    return {
        "frame": np.full(len(actors), frame.index),
        "actor_id": actors.id,
        "name": actors.name,
        "kind": actors.kind,
        "graded": grade.graded,
        **_named(POSE_EGO, pose_ego.T),
        **_named(POSE, actors.pose_world.T),
        **_named(SIZE, actors.size.T),
        **_named(NEAREST, corner(boxes_ego, sign).T),
        "corner_front": sign[:, 0] > 0,
        "corner_left": sign[:, 1] > 0,
        "view": truth.view,
        "faces": truth.faces,
        "points": grade.points,
        "visible_fraction": truth.visible_fraction,
        **_named(VELOCITY, actors.velocity_world.T),
        **_named(ACCELERATION, actors.acceleration_world.T),
        "yaw_rate_radps": actors.yaw_rate,
        "mode": actors.mode,
        **_named(ARTICULATION, actors.joint_angles.T),
        "changes_lane": actors.changes_lane,
        **_named(DEVIATION, actors.deviation.T),
        "ground_z_m": actors.ground_z,
        **_named(ATTITUDE, actors.attitude.T),
        "reflectivity": actors.reflectivity,
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
    return {
        "frame": np.full(len(truth.lost_unit), frame.index),
        "unit": truth.lost_unit,
        "beam": truth.lost_beam,
        "cause": truth.lost_cause,
    }


def _named(names: Iterable[str], values: Iterable[Any]) -> dict[str, Any]:
    return dict(zip(names, values, strict=True))


def _stack(values: Values, names: tuple[str, ...]) -> npt.NDArray[Any]:
    """Return several columns as an array (rows, columns)."""
    return np.stack([values[name] for name in names], axis=1)


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
    """Return the obstacles: the exact inverse of `write`; none if the file does not exist, as in older data sets.

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

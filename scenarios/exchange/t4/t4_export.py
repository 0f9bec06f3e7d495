"""Export of a run as a T4 data set of TIER IV: the tables of nuScenes with extensions, one scene, one merged LIDAR.

| path | content |
|---|---|
| `annotation/*.json` | the thirteen mandatory tables |
| `data/LIDAR_CONCAT/N.pcd.bin` | points of a scan: float32 x, y, z [m], echo pulse width [m], ring |
| `map/none.png` | one empty pixel: there is no map |
| `status.json` | the run |
| `tracking_result.json` | confirmed tracks of the run in the format of nuScenes' tracking task |

Points and ego poses are those of `base_link`, the rear axle on the ground.

The schema is that of TIER IV (docs/schema/table.md of t4-devkit; docs/t4_format_3d_detailed.md of
tier4_perception_dataset, version 1.4).
"""

from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.exchange.exported_run import cloud, confirmed_tracks
from luxloop.scenarios.exchange.nuscenes.nuscenes_export import (
    MODALITIES,
    Row,
    TableWriter,
    empty_png,
    rings,
    rotation,
    track_results,
    write_json,
)
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.sim.world import Actors, Kind, WorldFrame

MAP = "map/none.png"


def export(run: RecordedRun, folder: Path) -> None:
    """Write all frames of a run into an empty folder."""
    (folder / "data" / CHANNEL).mkdir(parents=True)
    tables, tracks = T4TableWriter(run, MAP), confirmed_tracks(run)
    results: dict[str, list[Row]] = {}
    for frame, scan, truth in run.scans():
        sample = tables.add(frame, truth)
        points = cloud(scan, rings(run, scan))
        points[:, 0] -= np.float32(run.rig.rear_axle_x_m)
        (folder / tables.filename(frame.index)).write_bytes(points.tobytes())
        results[sample] = track_results(sample, tracks.get(frame.index))
    (folder / "annotation").mkdir()
    for name, rows in tables.finish().items():
        write_json(folder / "annotation" / f"{name}.json", rows)
    write_json(folder / "tracking_result.json", {"meta": MODALITIES, "results": results})
    result = run.result
    source = {"scenario": result.scenario, "seed": result.seed, "luxloop": result.versions.get("luxloop")}
    write_json(folder / "status.json", source)
    (folder / "map").mkdir()
    (folder / MAP).write_bytes(empty_png())


CHANNEL = "LIDAR_CONCAT"
CATEGORIES = {
    Kind.CAR: "car", Kind.SUV: "car", Kind.VAN: "car", Kind.TRUCK: "truck", Kind.TRAILER_TRUCK: "trailer",
    Kind.BUS: "bus", Kind.MOTORCYCLE: "motorcycle", Kind.BICYCLE: "bicycle", Kind.PEDESTRIAN: "pedestrian",
}  # fmt: skip
"""T4 has no category for obstacles."""
LEVELS = {"none": 0.1, "partial": 0.5, "most": 1.0, "full": np.inf}
"""Visible fractions below which an actor has a level."""
DESCRIPTIONS = {
    "none": "visible by less than 10 %", "partial": "visible by 10 to 50 %", "most": "visible by 50 % or more",
    "full": "not occluded",
}  # fmt: skip


class T4TableWriter(TableWriter):
    """Collects the rows of all tables, frame by frame.

    Parameters
    ----------
    run, map_file
        As for `TableWriter`.
    """

    channel = CHANNEL
    categories = CATEGORIES

    def __init__(self, run: RecordedRun, map_file: str) -> None:
        super().__init__(run, map_file)
        self._rear_axle_x_m = run.rig.rear_axle_x_m

    def filename(self, frame: int) -> str:
        """Return the path of the points of a frame."""
        return f"data/{CHANNEL}/{frame}.pcd.bin"

    def finish(self) -> dict[str, list[Row]]:
        """Return all tables by name, with the columns that T4 adds."""
        tables = super().finish()
        for row in tables["category"]:
            row |= {"has_orientation": False, "has_number": False}
        for row in tables["calibrated_sensor"]:
            row["camera_distortion"] = []
        for row in tables["log"]:
            row["data_captured"] = row.pop("date_captured") + "-00-00-00"
        (scene,) = tables["scene"]
        scene["name"] = f"{self._name}_{scene['token']}"
        tables["visibility"] = [
            {"token": self._token("visibility", level), "level": level, "description": DESCRIPTIONS[level]}
            for level in LEVELS
        ]
        return tables

    def _ego_pose(self, frame: WorldFrame) -> Row:
        """Return the pose of the rear axle, with its velocity and acceleration on the axes of the ego.

        The rear axle is at r = (a, 0) from the box centre: v + w x r, and a - w^2 r without the angular acceleration.
        """
        ego, axle = frame.ego, np.array([self._rear_axle_x_m, 0.0])
        yaw, rate = float(ego.pose_world[2]), float(ego.yaw_rate)
        x, y = (ego.pose_world[:2] + turned(axle, yaw)).tolist()
        vx, vy = (turned(ego.velocity_world, -yaw) + rate * np.array([0.0, axle[0]])).tolist()
        ax, ay = (turned(ego.acceleration_world, -yaw) - rate**2 * axle).tolist()
        return {
            "translation": [x, y, 0.0], "rotation": rotation(yaw), "twist": [vx, vy, 0.0, rate, 0.0, 0.0],
            "acceleration": [ax, ay, 0.0], "geocoordinate": None,
        }  # fmt: skip

    def _file(self, frame: int) -> Row:
        return super()._file(frame) | {"fileformat": "pcd.bin", "is_valid": True, "info_filename": None}

    def _instance(self, token: str, rows: list[Row]) -> Row:
        return super()._instance(token, rows) | {"instance_name": f"{self._name}::{token}"}

    def _visibility(self, fraction: float) -> str:
        return self._token("visibility", next(level for level, end in LEVELS.items() if fraction < end))

    def _motion(self, actors: Actors, row: int) -> dict[str, Any]:
        velocity, acceleration = actors.velocity_world[row].tolist(), actors.acceleration_world[row].tolist()
        return {
            "velocity": [*velocity, 0.0], "acceleration": [*acceleration, 0.0], "automatic_annotation": False,
            "autolabel_metadata": None,
        }  # fmt: skip

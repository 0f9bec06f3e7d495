"""Rows of the tables of T4 data sets: those of nuScenes with extensions, in the frame of the rear axle (`base_link`).

The schema is that of TIER IV (docs/schema/table.md of t4-devkit; docs/t4_format_3d_detailed.md of
tier4_perception_dataset, version 1.4).
"""

from typing import Any

import numpy as np

from luxloop.scenarios.exchange.nuscenes.nuscenes_rows import Row, TableWriter, rotation
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.scenarios.offline.recorded_run import RecordedRun
from luxloop.sim.world import Actors, Kind, WorldFrame

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

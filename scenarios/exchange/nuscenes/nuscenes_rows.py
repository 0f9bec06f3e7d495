"""Rows of the nuScenes tables of a run, linked by tokens that depend on the run only."""

import hashlib
from typing import Any

import numpy as np

from luxloop.scenarios.exchange.nuscenes.nuscenes_names import (
    ATTRIBUTES,
    CATEGORIES,
    VISIBILITIES,
    attributes,
    visibility,
)
from luxloop.scenarios.grading.ownership import points_of_actors
from luxloop.scenarios.offline.recorded_run import RecordedRun
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Actors, Kind, WorldFrame

Row = dict[str, Any]

CHANNEL = "LIDAR_TOP"
NO_ROTATION = [1.0, 0.0, 0.0, 0.0]


def rotation(yaw: float) -> list[float]:
    """Return the quaternion w, x, y, z of a heading [rad]."""
    return [float(np.cos(0.5 * yaw)), 0.0, 0.0, float(np.sin(0.5 * yaw))]


class TableWriter:
    """Collects the rows of all tables, frame by frame.

    Parameters
    ----------
    run
        The run; tokens are hashes of its scenario, seed and trace hash, and of the row.
    map_file
        Path of the map in the folder.
    """

    channel = CHANNEL
    categories = CATEGORIES
    """Category of each kind; actors of other kinds have no annotations."""

    def __init__(self, run: RecordedRun, map_file: str) -> None:
        result = run.result
        self._name = f"{result.scenario}-seed{result.seed}"
        self._key = f"{self._name} {result.trace_hash}"
        self._description = str(result.config["description"])
        self._map_file = map_file
        self._samples: list[Row] = []
        self._data: list[Row] = []
        self._poses: list[Row] = []
        self._annotations: dict[str, list[Row]] = {}
        """Rows of each instance, in the order of time."""
        self._category: dict[str, str] = {}
        """Category of each instance."""

    def filename(self, frame: int) -> str:
        """Return the path of the points of a frame."""
        return f"samples/{self.channel}/{self._name}__{self.channel}__{frame:06d}.pcd.bin"

    def add(self, frame: WorldFrame, truth: ScanTruth) -> str:
        """Add a frame, and return the token of its sample."""
        sample = self._token("sample", frame.index)
        timestamp = round(1e6 * frame.time)
        pose = {"token": self._token("ego_pose", frame.index), "timestamp": timestamp, **self._ego_pose(frame)}
        self._poses.append(pose)
        self._samples.append({"token": sample, "timestamp": timestamp, "scene_token": self._token("scene")})
        self._data.append(
            {
                "token": self._token("sample_data", frame.index),
                "sample_token": sample,
                "ego_pose_token": pose["token"],
                "calibrated_sensor_token": self._token("calibrated_sensor"),
                "timestamp": timestamp,
                **self._file(frame.index),
            }
        )
        self._annotate(sample, frame, truth)
        return sample

    def finish(self) -> dict[str, list[Row]]:
        """Return all tables by name; rows are linked with their neighbours in time."""
        for rows in (self._samples, self._data, *self._annotations.values()):
            _link(rows)
        return {
            "sample": self._samples,
            "sample_data": self._data,
            "sample_annotation": [row for rows in self._annotations.values() for row in rows],
            "instance": [self._instance(token, rows) for token, rows in self._annotations.items()],
            "ego_pose": self._poses,
            **self._constant_tables(),
        }

    def _ego_pose(self, frame: WorldFrame) -> Row:
        """Return the pose of the frame of the points."""
        x, y, yaw = frame.ego.pose_world.tolist()
        return {"rotation": rotation(yaw), "translation": [x, y, 0.0]}

    def _file(self, frame: int) -> Row:
        """Return the description of the file of a frame."""
        return {
            "filename": self.filename(frame), "fileformat": "pcd", "width": 0, "height": 0, "is_key_frame": True,
        }  # fmt: skip

    def _annotate(self, sample: str, frame: WorldFrame, truth: ScanTruth) -> None:
        actors, points = frame.actors, points_of_actors(truth.actor_id, frame.actors.id)
        for a, actor in enumerate(actors.id.tolist()):
            kind = Kind(actors.kind[a])
            if kind not in self.categories:
                continue
            instance = self._token("instance", actor)
            self._category[instance] = self.categories[kind]
            (x, y, yaw), (length, width, height) = actors.pose_world[a].tolist(), actors.size[a].tolist()
            row: Row = {
                "token": self._token("sample_annotation", frame.index, actor),
                "sample_token": sample,
                "instance_token": instance,
                "visibility_token": self._visibility(float(truth.visible_fraction[a])),
                "attribute_tokens": [self._token("attribute", name) for name in attributes(kind, actors.mode[a])],
                "translation": [x, y, 0.5 * height],
                "size": [width, length, height],
                "rotation": rotation(yaw),
                "num_lidar_pts": int(points[a]),
                "num_radar_pts": 0,
                **self._motion(actors, a),
            }
            self._annotations.setdefault(instance, []).append(row)

    def _visibility(self, fraction: float) -> str:
        return visibility(fraction)

    def _motion(self, _actors: Actors, _row: int) -> Row:
        """Return further columns of an annotation; nuScenes has none."""
        return {}

    def _instance(self, token: str, rows: list[Row]) -> Row:
        return {
            "token": token,
            "category_token": self._token("category", self._category[token]),
            "nbr_annotations": len(rows),
            "first_annotation_token": rows[0]["token"],
            "last_annotation_token": rows[-1]["token"],
        }

    def _constant_tables(self) -> dict[str, list[Row]]:
        """Return the tables that do not depend on the frames, except for the ends of the scene."""
        scene, log = self._token("scene"), self._token("log")
        ends = [self._samples[end]["token"] if self._samples else "" for end in (0, -1)]
        sensor = self._token("sensor")
        names = list(dict.fromkeys(self.categories.values()))
        mounting: Row = {"translation": [0.0, 0.0, 0.0], "rotation": NO_ROTATION, "camera_intrinsic": []}
        drawn: Row = {"category": "semantic_prior", "filename": self._map_file}
        ride: Row = {
            "logfile": self._name,
            "vehicle": "luxloop",
            "date_captured": "1970-01-01",
            "location": "simulated",
        }
        return {
            "scene": [
                {
                    "token": scene,
                    "log_token": log,
                    "nbr_samples": len(self._samples),
                    "first_sample_token": ends[0],
                    "last_sample_token": ends[1],
                    "name": self._name,
                    "description": self._description,
                }
            ],
            "log": [{"token": log, **ride}],
            "map": [{"token": self._token("map"), "log_tokens": [log], **drawn}],
            "sensor": [{"token": sensor, "channel": self.channel, "modality": "lidar"}],
            "calibrated_sensor": [{"token": self._token("calibrated_sensor"), "sensor_token": sensor, **mounting}],
            "category": [self._named("category", name, index=index) for index, name in enumerate(names, 1)],
            "attribute": [self._named("attribute", name) for name in ATTRIBUTES],
            "visibility": [
                {"token": token, "level": level, "description": f"visible fraction up to {end:g}"}
                for token, (end, level) in VISIBILITIES.items()
            ],
        }

    def _named(self, table: str, name: str, **more: Any) -> Row:
        return {"token": self._token(table, name), "name": name, "description": "", **more}

    def _token(self, *parts: object) -> str:
        """Return 32 hexadecimal digits."""
        text = " ".join(map(str, (self._key, *parts)))
        return hashlib.sha256(text.encode()).hexdigest()[:32]


def _link(rows: list[Row]) -> None:
    """Set `prev` and `next` of rows in the order of time."""
    tokens = ["", *(row["token"] for row in rows), ""]
    for index, row in enumerate(rows):
        row["prev"], row["next"] = tokens[index], tokens[index + 2]

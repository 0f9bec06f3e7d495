"""Export of a run as a nuScenes folder: one scene, every scan a sample, one merged LIDAR.

| path | content |
|---|---|
| `v1.0-luxloop/*.json` | the thirteen tables of the nuScenes schema |
| `samples/LIDAR_TOP/*.pcd.bin` | points of a scan: float32 x, y, z [m], echo pulse width [m], ring |
| `maps/none.png` | the map that the schema needs: one empty pixel |
| `tracking_result.json` | confirmed tracks of the run in the format of the tracking task |

The points of all units are merged in the ego frame (centre of the ego's box, on the ground), so the calibrated sensor
is the identity. The ring is the layer plus the number of layers times the unit. Poses are the true ones in the world
frame.
"""

import hashlib
import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from luxloop.arrays import Floats32
from luxloop.scenarios.exchange.exported_run import cloud, confirmed_tracks
from luxloop.scenarios.grading.frame_truth import points_of_actors
from luxloop.scenarios.offline.recorded_scans import TRACK_HEIGHT_M, RecordedRun
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Actors, Kind, Mode, WorldFrame
from luxloop.tracker.scan import Scan

Row = dict[str, Any]

CHANNEL = "LIDAR_TOP"
NO_ROTATION = [1.0, 0.0, 0.0, 0.0]
CATEGORIES = {
    Kind.CAR: "vehicle.car", Kind.SUV: "vehicle.car", Kind.VAN: "vehicle.car", Kind.TRUCK: "vehicle.truck",
    Kind.TRAILER_TRUCK: "vehicle.truck", Kind.BUS: "vehicle.bus.rigid", Kind.MOTORCYCLE: "vehicle.motorcycle",
    Kind.BICYCLE: "vehicle.bicycle", Kind.PEDESTRIAN: "human.pedestrian.adult", Kind.OBSTACLE: "movable_object.debris",
}  # fmt: skip
RIDDEN = (Kind.MOTORCYCLE, Kind.BICYCLE)
ATTRIBUTES = (
    "vehicle.moving", "vehicle.stopped", "cycle.with_rider", "pedestrian.moving", "pedestrian.standing",
)  # fmt: skip
VISIBILITIES = {"1": (0.4, "v0-40"), "2": (0.6, "v40-60"), "3": (0.8, "v60-80"), "4": (1.0, "v80-100")}
"""Upper end and level of the visible fraction by token, as in nuScenes; 1 is in the last."""


def visibility(fraction: float) -> str:
    """Return the token of a visible fraction."""
    return next((token for token, (end, _) in VISIBILITIES.items() if fraction < end), "4")


def attributes(kind: Kind, mode: int) -> list[str]:
    """Return the attributes of an actor; obstacles have none."""
    stands = mode == Mode.STATIONARY
    if kind in RIDDEN:
        return ["cycle.with_rider"]
    if kind == Kind.PEDESTRIAN:
        return ["pedestrian.standing" if stands else "pedestrian.moving"]
    return [] if kind == Kind.OBSTACLE else ["vehicle.stopped" if stands else "vehicle.moving"]


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


VERSION = "v1.0-luxloop"
MAP = "maps/none.png"
TRACK_NAME = "car"
"""Tracks have no class."""
MODALITIES = {"use_camera": False, "use_lidar": True, "use_radar": False, "use_map": False, "use_external": False}


def export(run: RecordedRun, folder: Path) -> None:
    """Write all frames of a run into an empty folder."""
    clouds = folder / "samples" / CHANNEL
    clouds.mkdir(parents=True)
    tables = TableWriter(run, MAP)
    tracks = confirmed_tracks(run)
    results: dict[str, list[Row]] = {}
    for frame, scan, truth in run.scans():
        sample = tables.add(frame, truth)
        (folder / tables.filename(frame.index)).write_bytes(cloud(scan, rings(run, scan)).tobytes())
        results[sample] = track_results(sample, tracks.get(frame.index))
    (folder / VERSION).mkdir()
    for name, rows in tables.finish().items():
        write_json(folder / VERSION / f"{name}.json", rows)
    write_json(folder / "tracking_result.json", {"meta": MODALITIES, "results": results})
    (folder / "maps").mkdir()
    (folder / MAP).write_bytes(empty_png())


def rings(run: RecordedRun, scan: Scan) -> Floats32:
    """(N,) layer of each point plus the number of layers times its unit."""
    layers = max(len(mount.model.layer_elevation_deg) for mount in run.rig.mounts)
    return (layers * scan.unit.astype(np.int64) + scan.layer).astype(np.float32)


def write_json(path: Path, content: Any) -> None:
    """Write a table."""
    path.write_text(json.dumps(content, indent=0, allow_nan=False), encoding="utf-8")


def track_results(sample: str, tracks: pd.DataFrame | None) -> list[Row]:
    """Return the boxes of a sample; a track without a velocity has no such key."""
    rows = []
    for track in tracks.itertuples() if tracks is not None else ():
        row: Row = {
            "sample_token": sample,
            "translation": [track.x_world_m, track.y_world_m, 0.5 * TRACK_HEIGHT_M],
            "size": [track.width_m, track.length_m, TRACK_HEIGHT_M],
            "rotation": rotation(track.yaw_world_rad),
            "tracking_id": str(track.track_id),
            "tracking_name": TRACK_NAME,
            "tracking_score": 1.0,
        }
        velocity = [track.vx_world_mps, track.vy_world_mps]
        rows.append(row | ({"velocity": velocity} if np.isfinite(velocity).all() else {}))
    return rows


def empty_png() -> bytes:
    """Return a PNG of one black pixel, 8 bit greyscale."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0\0")) + chunk(b"IEND", b"")

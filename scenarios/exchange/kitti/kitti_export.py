"""Export of a run in the layout of the KITTI tracking benchmark, as one sequence.

| path | content |
|---|---|
| `training/velodyne/0000/000000.bin` | a scan: float32 x, y, z [m] in the ego frame, echo pulse width [m] |
| `training/label_02/0000.txt` | true boxes of all actors in camera axes |
| `training/calib/0000.txt` | matrices from ego to camera axes; there is no camera, so projections are identities |
| `training/poses/0000.txt` | true camera poses in the axes of the first frame, as KITTI odometry |
| `training/times/0000.txt` | times of the frames [s] |
| `results/0000.txt` | confirmed tracks of the run, without scores |

The velodyne frame is the ego frame (centre of the ego's box, on the ground); the camera has the same origin.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.exchange.exported_run import cloud, confirmed_tracks
from luxloop.scenarios.exchange.kitti.kitti_labels import heading
from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.offline.recorded_scans import TRACK_HEIGHT_M, RecordedRun
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Kind, WorldFrame

SEQUENCE = "0000"
TYPES = {
    Kind.CAR: "Car", Kind.SUV: "Car", Kind.VAN: "Van", Kind.TRUCK: "Truck", Kind.TRAILER_TRUCK: "Truck",
    Kind.BUS: "Misc", Kind.MOTORCYCLE: "Cyclist", Kind.BICYCLE: "Cyclist", Kind.PEDESTRIAN: "Pedestrian",
    Kind.OBSTACLE: "Misc",
}  # fmt: skip
"""KITTI has no type for buses and obstacles."""
TRACK_TYPE = "Car"
"""Tracks have no class."""
NO_IMAGE = "-1 -1 -1 -1"
"""2D box in the image."""
CAMERA_FROM_EGO = np.array([[0.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""(4, 4) transform from x forward, y left, z up to x right, y down, z forward."""
IDENTITY = np.eye(3, 4)
VISIBLE = (2.0 / 3.0, 1.0 / 3.0, 0.0)
"""Visible fractions above which `occluded` is 0, 1 and 2; 3 is unknown to KITTI, and hidden here."""


def export(run: RecordedRun, folder: Path) -> None:
    """Write all frames of a run into an empty folder."""
    training = folder / "training"
    clouds = training / "velodyne" / SEQUENCE
    clouds.mkdir(parents=True)
    tracks = confirmed_tracks(run)
    labels, results, poses, times = [], [], [], []
    for frame, scan, truth in run.scans():
        (clouds / f"{frame.index:06d}.bin").write_bytes(cloud(scan).tobytes())
        labels += _labels(frame, truth)
        if frame.index in tracks:
            results += _results(frame, tracks[frame.index])
        poses.append(frame.ego.pose_world)
        times.append(repr(frame.time))
    _write(training / "label_02", labels)
    _write(training / "calib", _calibration())
    _write(training / "poses", _poses(np.array(poses).reshape(-1, 3)))
    _write(training / "times", times)
    _write(folder / "results", results)


def _write(folder: Path, lines: list[str]) -> None:
    folder.mkdir()
    (folder / f"{SEQUENCE}.txt").write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


def _labels(frame: WorldFrame, truth: ScanTruth) -> list[str]:
    actors = frame.actors
    pose_ego = into_frame(actors.pose_world, frame.ego.pose_world)
    occluded = [sum(visible <= limit for limit in VISIBLE) for visible in truth.visible_fraction.tolist()]
    return [
        f"{frame.index} {actors.id[a]} {TYPES[Kind(actors.kind[a])]} 0 {occluded[a]} "
        f"{_box(pose_ego[a], *actors.size[a].tolist())}"
        for a in range(len(actors))
    ]


def _results(frame: WorldFrame, tracks: pd.DataFrame) -> list[str]:
    """Return the lines of the tracks in the true ego frame."""
    pose_world = tracks[["x_world_m", "y_world_m", "yaw_world_rad"]].to_numpy(np.float64)
    pose_ego = into_frame(pose_world, frame.ego.pose_world)
    return [
        f"{frame.index} {row.track_id} {TRACK_TYPE} -1 -1 {_box(pose, row.length_m, row.width_m, TRACK_HEIGHT_M)}"
        for pose, row in zip(pose_ego, tracks.itertuples(), strict=True)
    ]


def _box(pose_ego: Floats, length: float, width: float, height: float) -> str:
    """Return alpha, 2D box, size, position of the bottom centre and rotation_y."""
    x, y = pose_ego[:2].tolist()
    rotation_y = float(heading(pose_ego[2]))
    alpha = rotation_y - float(np.arctan2(-y, x))
    alpha -= 2.0 * np.pi * np.round(alpha / (2.0 * np.pi))
    return f"{alpha:.6f} {NO_IMAGE} {height:.6f} {width:.6f} {length:.6f} {-y:.6f} 0.000000 {x:.6f} {rotation_y:.6f}"


def _calibration() -> list[str]:
    """Return the lines of the calibration, with the keys of the tracking benchmark."""
    matrices = {f"P{camera}:": IDENTITY for camera in range(4)}
    matrices |= {"R_rect": np.eye(3), "Tr_velo_cam": CAMERA_FROM_EGO[:3], "Tr_imu_velo": IDENTITY}
    return [f"{key} {_numbers(matrix)}" for key, matrix in matrices.items()]


def _poses(ego_pose_world: Floats) -> list[str]:
    """Return the camera poses (3, 4) row by row, in the camera axes of the first frame."""
    world = [_transform(pose) for pose in ego_pose_world]
    first = CAMERA_FROM_EGO @ np.linalg.inv(world[0]) if world else IDENTITY
    return [_numbers((first @ pose @ CAMERA_FROM_EGO.T)[:3]) for pose in world]


def _transform(pose: Floats) -> Floats:
    """(4, 4) transform of a pose (3,) on the ground."""
    x, y, yaw = pose.tolist()
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([[cos, -sin, 0.0, x], [sin, cos, 0.0, y], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def _numbers(matrix: Floats) -> str:
    return " ".join(f"{value:.12e}" for value in matrix.ravel().tolist())

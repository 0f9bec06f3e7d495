"""A recorded run as a log of Argoverse 2."""

import numpy as np
import pyarrow as pa
import pyarrow.feather

from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.offline.recorded_scans import RecordedRun


def stamp_ns(frame):
    """Times of Argoverse 2 are integers since 1970."""
    return 315_968_112_000_000_000 + round(1e9 * frame.time)


def feather(path, **columns):
    path.parent.mkdir(parents=True, exist_ok=True)
    pyarrow.feather.write_feather(pa.table(columns), path)


def quaternion(yaw):
    """Columns of rotations about the vertical, of the sign that has no effect."""
    half = 0.5 * np.asarray(yaw)
    return {"qw": -np.cos(half), "qx": 0.0 * half, "qy": 0.0 * half, "qz": -np.sin(half)}


def write_av2(run, folder, ground_m=None):
    """Write a run as the README of Argoverse 2's sensor data set describes a log, with ground at a height if given."""
    poses, boxes = [], []
    for frame, scan, _ in RecordedRun.open(run).scans():
        poses.append((stamp_ns(frame), *frame.ego.pose_world))
        ground = _ground(ground_m)
        points, more = np.concatenate([scan.points_ego, ground]), np.zeros(len(ground))
        names = dict(zip("xyz", points.T, strict=True))
        ring = np.append(4 * scan.unit + scan.layer, more).astype(np.uint8)
        offset = np.append(np.round(1e9 * (scan.time_offset - scan.time_offset.min())), more).astype(np.int32)
        shown = {**names, "intensity": np.zeros(len(points), np.uint8), "laser_number": ring, "offset_ns": offset}
        feather(folder / "sensors" / "lidar" / f"{stamp_ns(frame)}.feather", **shown)
        pose_ego = into_frame(frame.actors.pose_world, frame.ego.pose_world)
        boxes += [
            (stamp_ns(frame), *row) for row in zip(frame.actors.name, *pose_ego.T, *frame.actors.size.T, strict=True)
        ]
    time, x, y, yaw = map(np.array, zip(*poses, strict=True))
    feather(
        folder / "city_SE3_egovehicle.feather",
        timestamp_ns=time.astype(np.int64), **quaternion(yaw), tx_m=x, ty_m=y, tz_m=0.0 * x - 24.0,
    )  # fmt: skip
    time, name, x, y, yaw, length, width, height = map(np.array, zip(*boxes, strict=True))
    feather(
        folder / "annotations.feather",
        timestamp_ns=time.astype(np.int64), track_uuid=name, category=["REGULAR_VEHICLE"] * len(name),
        length_m=length, width_m=width, height_m=height, **quaternion(yaw), tx_m=x, ty_m=y, tz_m=0.5 * height,
        num_interior_pts=np.full(len(name), 20),
    )  # fmt: skip
    return folder


def _ground(height_m):
    """Points of the ground (N, 3) around the ego; none without a height."""
    across = np.arange(-15.0, 15.1, 0.5) if height_m is not None else np.zeros(0)
    x, y = (axis.ravel() for axis in np.meshgrid(across, across))
    return np.column_stack([x, y, np.full(len(x), height_m or 0.0)])

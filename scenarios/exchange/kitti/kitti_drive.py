"""Sweeps, ego poses and true boxes of one sequence of a KITTI tracking folder.

Points are in the velodyne frame, whose height above the ground is in no file. The ego frame is the velodyne frame
without its height. Poses are those of `oxts`, by the Mercator projection of KITTI's development kit of raw data
(`convertOxtsToPose.m`; Geiger et al. 2013, Vision meets robotics), or the camera poses of `poses`, as in KITTI odometry
and in the exports of luxloop. Boxes are turned from camera axes into the velodyne frame by the calibration.
"""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exchange.box_table import BoxTable
from luxloop.scenarios.exchange.kitti import kitti_labels
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.formats.kitti_points import LAYOUTS
from luxloop.scenarios.recordings.formats.point_files import sweep_of_table
from luxloop.scenarios.recordings.sweep import DataSet, PoseList, Sweep

EARTH_RADIUS_M = 6378137.0
POINT = LAYOUTS[4]


def open_recording(path: Path, sequence: str | None, rate_hz: float) -> DataSet:
    """Open a sequence of a folder, by its number of four digits; the only one if None.

    Raises
    ------
    InputError
        A file is missing or damaged, or the sequence is unknown.
    """
    root = path / "training" if (path / "training").is_dir() else path
    name = _sequence(path, root / "velodyne", sequence)
    files = sorted((root / "velodyne" / name).glob("[0-9]*.bin"), key=lambda file: int(file.stem))
    if not files:
        raise InputError(f"{root / 'velodyne' / name}: no 000000.bin; give a folder with sweeps")
    frames = np.array([int(file.stem) for file in files])
    times, labels = root / "times" / f"{name}.txt", root / "label_02" / f"{name}.txt"
    calibration = _calibration(root / "calib" / f"{name}.txt")
    time = _of_frames(times, numbers(times, 1)[:, 0], frames) if times.is_file() else frames / rate_hz
    poses = _poses(root, name, calibration)
    rows = np.column_stack([time, *(_of_frames(root, column, frames) for column in poses.T)])

    def read(row: int) -> list[Sweep]:
        with readable(files[row], "points of KITTI"):
            points = np.fromfile(files[row], POINT)
            if POINT.itemsize * len(points) != files[row].stat().st_size:
                raise ValueError("its size is not a multiple of four float32")
        return [sweep_of_table(points, float(time[row]), 0)]

    return DataSet(
        path,
        frames,
        read,
        PoseList(rows=[tuple(row) for row in rows.tolist()]),
        truth=(lambda: [_boxes(labels, calibration)]) if labels.is_file() else None,
    )


def _sequence(path: Path, velodyne: Path, name: str | None) -> str:
    known = sorted(folder.name for folder in velodyne.glob("[0-9]*") if folder.is_dir())
    if not known:
        raise InputError(f"{path}: no velodyne/0000 in it or in its folder training; give a KITTI tracking folder")
    if name is None and len(known) == 1:
        return known[0]
    if name not in known:
        what = f"no sequence {name}" if name else f"has {len(known)} sequences"
        raise InputError(f"{path}: {what}; give --scene, one of {', '.join(known)[:300]}")
    return name


def _calibration(path: Path) -> dict[str, Floats]:
    """Return (4, 4) `cam_from_velo` and `velo_from_imu`; identity where a key is missing."""
    found = {}
    with readable(path, "calibration of KITTI"):
        for line in path.read_text(encoding="utf-8").splitlines():
            key, *words = line.replace(":", " ").split() or [""]
            found[key] = np.array(words, dtype=np.float64)
        camera = found.get("Tr_velo_cam", found.get("Tr_velo_to_cam"))
        if camera is None:
            raise ValueError("no Tr_velo_cam in it")
        rectified = found.get("R_rect", found.get("R0_rect", np.eye(3)))
        imu = found.get("Tr_imu_velo", found.get("Tr_imu_to_velo", np.eye(3, 4)))
        return {
            "cam_from_velo": _square(rectified.reshape(3, 3)) @ _square(camera.reshape(3, 4)),
            "velo_from_imu": _square(imu.reshape(3, 4)),
        }


def _square(matrix: Floats) -> Floats:
    """(4, 4) transform of a rotation (3, 3) or of the upper rows (3, 4)."""
    found = np.eye(4)
    found[:3, : matrix.shape[1]] = matrix
    return found


def _poses(root: Path, name: str, calibration: dict[str, Floats]) -> Floats:
    """(F, 3) x [m], y [m], yaw [rad] of the velodyne frame."""
    oxts, cameras = root / "oxts" / f"{name}.txt", root / "poses" / f"{name}.txt"
    if oxts.is_file():
        imu = _mercator(numbers(oxts, 6)[:, [0, 1, 5]])
        return _planar(imu @ np.linalg.inv(calibration["velo_from_imu"]))
    if cameras.is_file():
        world = np.array([_square(row.reshape(3, 4)) for row in numbers(cameras, 12)[:, :12]]).reshape(-1, 4, 4)
        velo = calibration["cam_from_velo"]
        return _planar(np.linalg.inv(velo) @ world @ velo)
    raise InputError(f"{root}: has no poses of the ego, {oxts.relative_to(root)} or {cameras.relative_to(root)}")


def _mercator(rows: Floats) -> Floats:
    """(F, 4, 4) transforms on the ground of latitude [deg], longitude [deg] and yaw [rad] (F, 3)."""
    latitude, longitude, yaw = rows.T
    scale = np.cos(np.radians(latitude[:1]))
    found = np.tile(np.eye(4), (len(rows), 1, 1))
    found[:, 0, 0] = found[:, 1, 1] = np.cos(yaw)
    found[:, 1, 0], found[:, 0, 1] = np.sin(yaw), -np.sin(yaw)
    found[:, 0, 3] = scale * EARTH_RADIUS_M * np.radians(longitude)
    found[:, 1, 3] = scale * EARTH_RADIUS_M * np.log(np.tan(np.radians(90.0 + latitude) / 2.0))
    return found


def _planar(transforms: Floats) -> Floats:
    """(F, 3) x, y, yaw of transforms (F, 4, 4)."""
    yaw = np.arctan2(transforms[:, 1, 0], transforms[:, 0, 0])
    return np.column_stack([transforms[:, :2, 3], yaw])


def numbers(path: Path, least: int) -> Floats:
    """(F, >= least) numbers of the lines of a file."""
    with readable(path, "numbers of KITTI"), warnings.catch_warnings(action="error"):  # a file without any is a warning
        found = np.loadtxt(path, dtype=np.float64, ndmin=2)
        if found.shape[1] < least or not np.isfinite(found).all():
            raise ValueError(f"a line should have {least} numbers")
    return found


def _of_frames(path: Path, values: Floats, frames: Ints) -> Floats:
    if frames.max() >= len(values):
        raise InputError(f"{path}: has {len(values)} lines, but a sweep has the number {frames.max()}; give all lines")
    found: Floats = values[frames]
    return found


def _boxes(path: Path, calibration: dict[str, Floats]) -> BoxTable:
    """Return the boxes of a file of labels in the velodyne frame."""
    table = kitti_labels.read(path)
    velo = np.linalg.inv(calibration["cam_from_velo"])
    x, y, heading = table.boxes[:, :3].T
    height = np.zeros(len(table)) if table.z_m is None else table.z_m
    centre = np.column_stack([-y, -height, x]) @ velo[:3, :3].T + velo[:3, 3]
    forward = np.column_stack([-np.sin(heading), np.zeros(len(table)), np.cos(heading)]) @ velo[:3, :3].T
    turned = np.arctan2(forward[:, 1], forward[:, 0])
    return replace(table, axes="ego", boxes=np.column_stack([centre[:, :2], turned, table.boxes[:, 3:]]))

"""True vehicles of an import, from poses on topics or from tables of boxes, and their labels in the scans."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.dataset.dataset_columns import Values
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exchange import file_formats
from luxloop.scenarios.exchange.box_table import EGO_AXES, BoxTable
from luxloop.scenarios.grading.plane_geometry import into_frame, turned
from luxloop.scenarios.recordings.import_options import HEIGHT_M, ImportOptions
from luxloop.scenarios.recordings.pose_track import WINDOW_S, Motion, PoseTrack
from luxloop.scenarios.recordings.sweep import DataSet, PoseList, RecordingSource
from luxloop.sim.modes import ModeClassifier, ModeLimits
from luxloop.sim.world import Kind

STATE = (
    "x_world_m", "y_world_m", "heading_world_rad", "vx_world_mps", "vy_world_mps", "ax_world_mps2", "ay_world_mps2",
    "yaw_rate_radps",
)  # fmt: skip
"""Columns of the motion of a vehicle."""


def scaled(rows: Floats, options: ImportOptions) -> Floats:
    """Return time, x, y, yaw (M, 4) with the factors of the options applied."""
    factor = np.array([options.scale_time, options.scale_length, options.scale_length, 1.0])
    return np.asarray(rows * factor)


class TrueVehicle(NamedTuple):
    """A vehicle with true poses, scaled."""

    name: str
    kind: Kind
    size: Floats
    """(3,) length, width, height [m]."""
    poses: PoseTrack
    """Poses of the centre of its box."""


class RecordedLabels:
    """Labels of all scans.

    Parameters
    ----------
    vehicles
        The vehicles; their positions are the ids.
    first_pose
        (3,) scaled pose of the odometry frame in the frame of the poses.
    """

    def __init__(self, vehicles: Sequence[TrueVehicle], first_pose: Floats) -> None:
        self._vehicles, self._first_pose = vehicles, first_pose
        self._classifier = ModeClassifier(ModeLimits())

    def rows(self, frame: int, time: float) -> Values:
        """Return the rows of one scan, of which `time` is the scaled time on the clock of the recording [s]."""
        motions = [vehicle.poses.motion(time) for vehicle in self._vehicles]
        present = np.array([row for row, motion in enumerate(motions) if motion is not None], dtype=np.int64)
        state = _states([motion for motion in motions if motion is not None], self._first_pose)
        vehicles = [self._vehicles[row] for row in present]
        size = np.array([vehicle.size for vehicle in vehicles]).reshape(-1, 3)
        return {
            "frame": np.full(len(present), frame),
            "actor_id": present,
            "name": np.array([vehicle.name for vehicle in vehicles], dtype=np.str_),
            "kind": np.array([vehicle.kind for vehicle in vehicles], dtype=np.int64),
            **dict(zip(STATE, state.T, strict=True)),
            **dict(zip(("length_m", "width_m", "height_m"), size.T, strict=True)),
            "mode": self._classifier.modes(present, state[:, 3:5], state[:, 5:7]),
        }


def _states(motions: list[Motion], first_pose: Floats) -> Floats:
    """(A, 8) x, y, yaw, vx, vy, ax, ay, yaw rate in the odometry frame."""
    if not motions:
        return np.empty((0, 8))
    pose = into_frame(np.array([motion.pose for motion in motions]), first_pose)
    velocity = turned(np.array([motion.velocity for motion in motions]), -first_pose[2])
    acceleration = turned(np.array([motion.acceleration for motion in motions]), -first_pose[2])
    return np.column_stack([pose, velocity, acceleration, [motion.yaw_rate for motion in motions]])


def of_topics(source: RecordingSource, options: ImportOptions, ego_frame: str) -> list[TrueVehicle]:
    """Return the vehicles whose poses are on topics.

    Raises
    ------
    InputError
        A topic has no poses, or poses in another frame than those of the ego.
    """
    found = []
    for vehicle in options.truth:
        poses = source.poses(vehicle.topic)
        if poses.frame and ego_frame and poses.frame != ego_frame:
            raise InputError(
                f"--truth {vehicle.topic}: its poses are in the frame {poses.frame}, those of --odometry in "
                f"{ego_frame}; record both in one frame"
            )
        size = options.scale_length * np.array([vehicle.length_m, vehicle.width_m, vehicle.height_m])
        rows = scaled(vehicle.centres(np.array(poses.rows)) - [options.truth_delay_s, 0.0, 0.0, 0.0], options)
        found.append(TrueVehicle(vehicle.name, Kind.CAR, size, PoseTrack(rows)))
    return found


def tables_of(source: RecordingSource, options: ImportOptions) -> list[BoxTable]:
    """Return the tables of true boxes of an import: those of `truth_files`, or else of the data set.

    Raises
    ------
    TracksError
        A file is not valid.
    """
    if options.truth_files:
        return [_preferred(file_formats.read(path, "truth")) for path in options.truth_files]
    truth = source.truth if isinstance(source, DataSet) and not options.truth else None
    return [_preferred(truth())] if truth else []


def _preferred(tables: list[BoxTable]) -> BoxTable:
    """Return the table about the ego, if a file has one: odometry drifts against other axes."""
    return min(tables, key=lambda table: table.axes not in EGO_AXES)


KINDS = {
    **{kind.name.lower(): kind for kind in Kind},
    **dict.fromkeys(("regular_vehicle", "vehicle"), Kind.CAR),
    **dict.fromkeys(("large_vehicle", "box_truck", "truck_cab"), Kind.TRUCK),
    **dict.fromkeys(("trailer", "vehicular_trailer"), Kind.TRAILER_TRUCK),
    **dict.fromkeys(("school_bus", "articulated_bus", "tram"), Kind.BUS),
    **dict.fromkeys(("cyclist", "bicyclist"), Kind.BICYCLE),
    **dict.fromkeys(("person", "person_sitting"), Kind.PEDESTRIAN),
    "motorcyclist": Kind.MOTORCYCLE,
}  # fmt: skip
"""Kinds by the names of classes of luxloop, KITTI, nuScenes and Argoverse 2; others are obstacles."""
PERIODS_OF_A_GAP, PERIODS_OF_A_WINDOW = 1.5, 3.5
"""Periods of the boxes over which a vehicle is present between two boxes, and of half a window of derivatives: a
vehicle without a box in its frame is absent, and four boxes give derivatives at its ends, too."""
TOLERANCE_S = 1e-3
"""[s] Times of boxes and scans differ by less: programs round times."""


def of_table(
    table: BoxTable, time_of: Mapping[int, float], ego: PoseTrack | None, options: ImportOptions
) -> list[TrueVehicle]:
    """Return the vehicles of a table of true boxes.

    Parameters
    ----------
    table
        Boxes about the ego, or else in the frame of its poses.
    time_of
        Scaled time of each scan on the clock of the recording [s], by the number of its frame.
    ego
        Scaled poses of the ego; None for an ego that stands.
    options
        Options of the import.

    Raises
    ------
    InputError
        The boxes have neither numbers of frames nor times, or none of them is at the time of a scan.
    """
    time = options.scale_time * table.time_s if table.time_s is not None else _times(table, time_of)
    poses = scaled(np.column_stack([time, table.boxes[:, :3]]), options)
    poses[:, 0] = time
    if table.axes in EGO_AXES and ego is not None:
        poses[:, 1:] = _from_ego(poses, ego)
    poses[:, 0] -= options.scale_time * options.truth_delay_s
    scans = np.array(sorted(time_of.values()))
    _require_overlap(table, poses[:, 0], scans)
    period = np.diff(np.unique(poses[np.isfinite(poses[:, 0]), 0]))
    period_s = float(np.median(period[period > TOLERANCE_S])) if (period > TOLERANCE_S).any() else 0.0
    gap_s, window_s = PERIODS_OF_A_GAP * period_s, max(WINDOW_S, PERIODS_OF_A_WINDOW * period_s)
    height = np.full(len(table), HEIGHT_M) if table.height_m is None else table.height_m
    size = options.scale_length * np.column_stack([table.boxes[:, 3:], height])
    names, first, of = np.unique(table.id, return_index=True, return_inverse=True)
    return [
        TrueVehicle(
            str(name),
            Kind.CAR if table.kind is None else KINDS.get(str(table.kind[first[k]]), Kind.OBSTACLE),
            np.median(size[of == k], axis=0),
            PoseTrack(poses[of == k], gap_s, TOLERANCE_S, window_s),
        )
        for k, name in enumerate(names)
    ]


def _times(table: BoxTable, time_of: Mapping[int, float]) -> Floats:
    """(N,) time of the scan of each box [s], NaN without a scan."""
    if table.frame is None:
        raise InputError(f"{table.source}: its boxes have neither frame nor time_s; add one of them")
    return np.array([time_of.get(frame, np.nan) for frame in table.frame.tolist()], dtype=np.float64)


def _from_ego(rows: Floats, ego: PoseTrack) -> Floats:
    """(M, 3) x, y, yaw in the frame of the ego's poses, of rows (M, 4) about the ego; NaN without its pose."""
    times, of = np.unique(rows[:, 0], return_inverse=True)
    known = [pose if (pose := ego.at(time)) is not None else np.full(3, np.nan) for time in times.tolist()]
    origin = np.array(known).reshape(-1, 3)[of.reshape(-1)]
    return np.column_stack([origin[:, :2] + _each_turned(rows[:, 1:3], origin[:, 2]), origin[:, 2] + rows[:, 3]])


def _each_turned(points: Floats, angle: Floats) -> Floats:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.column_stack([cos * points[:, 0] - sin * points[:, 1], sin * points[:, 0] + cos * points[:, 1]])


def _require_overlap(table: BoxTable, time: Floats, scans: Floats) -> None:
    known = time[np.isfinite(time)]
    if not len(table) or not len(scans):
        return
    if not len(known):
        raise InputError(f"{table.source}: none of its frames is a sweep of the recording; number them from 0")
    if known.min() > scans[-1] or known.max() < scans[0]:
        raise InputError(
            f"{table.source}: its boxes are from {known.min():.1f} to {known.max():.1f} s, scans from {scans[0]:.1f} "
            f"to {scans[-1]:.1f} s; give times on the clock of the recording"
        )


def vehicles_of(
    source: RecordingSource,
    options: ImportOptions,
    poses: PoseList,
    ego: PoseTrack | None,
    time_of: Mapping[int, float],
) -> list[TrueVehicle]:
    """Return all true vehicles of an import; parameters as for `of_table`, and `poses` of the ego as recorded."""
    frames: Any = source.frames if isinstance(source, DataSet) else None
    if frames is not None:
        time_of = {int(frames[number]): time for number, time in time_of.items()}
    of_tables = [of_table(table, time_of, ego, options) for table in tables_of(source, options)]
    return [*of_topics(source, options, poses.frame), *(vehicle for vehicles in of_tables for vehicle in vehicles)]

"""Labels of a recording: the vehicles with recorded poses, scan by scan, in the odometry frame."""

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.dataset.dataset_columns import Values
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.plane_geometry import into_frame, turned
from luxloop.scenarios.recordings.import_options import ImportOptions
from luxloop.scenarios.recordings.pose_track import Motion, PoseTrack
from luxloop.scenarios.recordings.sweep import PoseList, RecordingSource
from luxloop.scenarios.recordings.truth_option import TruthOption
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


class RecordedLabels:
    """Labels of all scans.

    Parameters
    ----------
    source
        The recording.
    options
        Options of the import.
    ego
        Poses of the ego, whose frame those of the vehicles must share.

    Raises
    ------
    InputError
        A topic has no poses, or poses in another frame.
    """

    def __init__(self, source: RecordingSource, options: ImportOptions, ego: PoseList) -> None:
        self._vehicles = options.truth
        self._scale = options.scale_length
        self._tracks = [self._track(source, options, vehicle, ego) for vehicle in options.truth]
        self._classifier = ModeClassifier(ModeLimits())

    def _track(self, source: RecordingSource, options: ImportOptions, vehicle: TruthOption, ego: PoseList) -> PoseTrack:
        poses = source.poses(vehicle.topic)
        if poses.frame and ego.frame and poses.frame != ego.frame:
            raise InputError(
                f"--truth {vehicle.topic}: its poses are in the frame {poses.frame}, those of --odometry in "
                f"{ego.frame}; record both in one frame"
            )
        return PoseTrack(scaled(vehicle.centres(np.array(poses.rows)), options))

    def rows(self, frame: int, time: float, first_pose: Floats) -> Values:
        """Return the rows of one scan.

        Parameters
        ----------
        frame
            Number of the scan.
        time
            Its scaled time on the clock of the recording [s].
        first_pose
            (3,) scaled pose of the odometry frame in the frame of the poses.
        """
        motions = [track.motion(time) for track in self._tracks]
        present = np.array([row for row, motion in enumerate(motions) if motion is not None], dtype=np.int64)
        state = _states([motion for motion in motions if motion is not None], first_pose)
        vehicles = [self._vehicles[row] for row in present]
        sides = [(vehicle.length_m, vehicle.width_m, vehicle.height_m) for vehicle in vehicles]
        size = self._scale * np.array(sides, dtype=np.float64).reshape(-1, 3)
        return {
            "frame": np.full(len(present), frame),
            "actor_id": present,
            "name": np.array([vehicle.name for vehicle in vehicles], dtype=np.str_),
            "kind": np.full(len(present), Kind.CAR),
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

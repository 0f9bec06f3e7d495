"""Import of a recording as recorded scans, with the labels of recorded poses."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.dataset.dataset_columns import Values
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.plane_geometry import into_frame, turned
from luxloop.scenarios.recordings import recording_writer
from luxloop.scenarios.recordings.ego_mount import EgoMount
from luxloop.scenarios.recordings.ego_scans import EgoScans
from luxloop.scenarios.recordings.import_options import ImportOptions, TruthOption
from luxloop.scenarios.recordings.layer_cut import ElevationCut, HeightCut
from luxloop.scenarios.recordings.pose_track import Motion, PoseTrack
from luxloop.scenarios.recordings.sweep import PoseList, RecordingSource
from luxloop.scenarios.run import progress, versions
from luxloop.sensor_model.rig.rig import Rig
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


@dataclass(frozen=True, slots=True)
class Imported:
    """Contents of the recorded scans."""

    frames: int
    duration_s: float
    points: int
    layers: int
    skipped: dict[str, int]
    """Sweeps that are not in the scans, by reason; without those that are 0."""
    clocks: str
    """`EgoScans.clocks`."""


def import_recording(source: RecordingSource, options: ImportOptions, out: Path, rig: Rig | None = None) -> Imported:
    """Write the recorded scans of a recording to a folder, which appears as a whole.

    Parameters
    ----------
    source
        The opened recording.
    options
        Mounts, cuts, poses and scale.
    out
        Folder; an earlier recording there is replaced.
    rig
        Rig of the mounts, kept beside the scans; None without a rig file.

    Raises
    ------
    InputError
        The recording is damaged, or no sweep of it can be used.
    OutputError
        The folder cannot be written.
    """
    ego_poses = source.poses(options.odometry) if options.odometry else PoseList()
    ego = PoseTrack(scaled(np.array(ego_poses.rows), options)) if options.odometry else None
    labels = RecordedLabels(source, options, ego_poses) if options.truth else None
    scans = EgoScans(options, ego)
    points, layers, start, end = 0, 0, 0.0, 0.0
    with recording_writer.create(out, labelled=labels is not None) as (folder, writer):
        sweeps = progress.steps("import", source.count, "sweeps", source.sweeps())
        for time, scan in scans.of(sweeps):
            start = start if writer.frames else time
            end, points, layers = scan.time, points + len(scan), max(layers, int(scan.layer.max(initial=0)) + 1)
            writer.add(scan, labels.rows(writer.frames, time, scans.first_pose) if labels else None)
        skipped = {reason: number for reason, number in asdict(scans.skipped).items() if number}
        if not writer.frames:
            reasons = ", ".join(f"{number} {reason}" for reason, number in skipped.items()) or "it has none"
            clocks = f"; {scans.clocks}; --time log takes the times of logging" if scans.clocks else ""
            raise InputError(
                f"{options.files[0]}: no sweep can be used ({reasons}){clocks}; check cuts, poses and --topic"
            )
        found = Imported(writer.frames, end, points, layers, skipped, scans.clocks)
        writer.finish(
            {**asdict(found), "start_time_s": start, **_summary(options, scans.mounts)}, _origin(options, found)
        )
        if rig is not None:
            (folder / "rig.json").write_text(json.dumps(asdict(rig), indent=2) + "\n", encoding="utf-8")
    return found


def _summary(options: ImportOptions, used: list[EgoMount]) -> dict[str, Any]:
    mounts = [{"origin_ego_m": mount.origin_ego.tolist(), "R_ego_unit": mount.R_ego_unit.tolist()} for mount in used]
    return {
        "files": list(options.files),
        "mounts": mounts,
        "level": options.level,
        "cut": _cut(options.cut),
        "kept_heights_m": options.heights_m,
        "sweep_time_s": options.sweep_time_s,
        "odometry": options.odometry,
        "truth": [asdict(vehicle) for vehicle in options.truth],
        "scale_length": options.scale_length,
        "scale_time": options.scale_time,
        "versions": versions.installed(),
    }


def _cut(cut: ElevationCut | HeightCut | None) -> dict[str, Any] | None:
    return None if cut is None else asdict(cut)


def _origin(options: ImportOptions, found: Imported) -> str:
    return (
        f"{found.frames} scans of {found.duration_s:.1f} s from {', '.join(options.files)}; lengths times "
        f"{options.scale_length:g}, times times {options.scale_time:g}."
    )

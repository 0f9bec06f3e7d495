"""Import of a recording as recorded scans, with the labels of recorded poses."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings import recorded_labels, recording_writer
from luxloop.scenarios.recordings.ego_mount import EgoMount
from luxloop.scenarios.recordings.ego_scans import EgoScans
from luxloop.scenarios.recordings.import_options import ImportOptions
from luxloop.scenarios.recordings.pose_track import PoseTrack
from luxloop.scenarios.recordings.recorded_labels import RecordedLabels, TrueVehicle, scaled
from luxloop.scenarios.recordings.recording_writer import RecordingWriter
from luxloop.scenarios.recordings.sweep import DataSet, PoseList, RecordingSource
from luxloop.scenarios.run import progress, versions
from luxloop.sensor_model.rig.rig import Rig


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
    poses = _ego_poses(source, options)
    ego = PoseTrack(scaled(np.array(poses.rows), options)) if poses.rows else None
    scans = EgoScans(options, ego)
    points, layers, start, end = 0, 0, 0.0, 0.0
    with recording_writer.create(out, labelled=labelled(source, options)) as (folder, writer):
        sweeps = progress.steps("import", source.count, "sweeps", source.sweeps())
        for time, scan in scans.of(sweeps):
            start = start if writer.frames else time
            end, points, layers = scan.time, points + len(scan), max(layers, int(scan.layer.max(initial=0)) + 1)
            writer.add(scan)
        skipped = {reason: number for reason, number in asdict(scans.skipped).items() if number}
        if not writer.frames:
            reasons = ", ".join(f"{number} {reason}" for reason, number in skipped.items()) or "it has none"
            clocks = f"; {scans.clocks}; --time log takes the times of logging" if scans.clocks else ""
            raise InputError(
                f"{options.files[0]}: no sweep can be used ({reasons}){clocks}; check cuts, poses and --topic"
            )
        _label(writer, scans, recorded_labels.vehicles_of(source, options, poses, ego, scans.time_of))
        found = Imported(writer.frames, end, points, layers, skipped, scans.clocks)
        writer.finish(
            {**asdict(found), "start_time_s": start, **_summary(options, scans.mounts)}, _origin(options, found)
        )
        if rig is not None:
            (folder / "rig.json").write_text(json.dumps(asdict(rig), indent=2) + "\n", encoding="utf-8")
    return found


def labelled(source: RecordingSource, options: ImportOptions) -> bool:
    """Return True if an import has true vehicles."""
    return bool(options.truth or options.truth_files or (isinstance(source, DataSet) and source.truth))


def _ego_poses(source: RecordingSource, options: ImportOptions) -> PoseList:
    if options.odometry:
        return source.poses(options.odometry)
    return source.ego if isinstance(source, DataSet) else PoseList()


def _label(writer: RecordingWriter, scans: EgoScans, vehicles: list[TrueVehicle]) -> None:
    """Write the labels of all scans, if there are vehicles."""
    labels = RecordedLabels(vehicles, scans.first_pose)
    for frame, time in enumerate(scans.time_of.values() if vehicles else ()):
        writer.label(labels.rows(frame, time))


def _summary(options: ImportOptions, used: list[EgoMount]) -> dict[str, Any]:
    mounts = [{"origin_ego_m": mount.origin_ego.tolist(), "R_ego_unit": mount.R_ego_unit.tolist()} for mount in used]
    return {
        "files": list(options.files),
        "mounts": mounts,
        "level": options.level,
        "cut": None if options.cut is None else asdict(options.cut),
        "kept_heights_m": options.heights_m,
        "sweep_time_s": options.sweep_time_s,
        "odometry": options.odometry,
        "truth": [asdict(vehicle) for vehicle in options.truth],
        "truth_files": [path.name for path in options.truth_files],
        "truth_delay_s": options.truth_delay_s,
        "scale_length": options.scale_length,
        "scale_time": options.scale_time,
        "versions": versions.installed(),
    }


def _origin(options: ImportOptions, found: Imported) -> str:
    return (
        f"{found.frames} scans of {found.duration_s:.1f} s from {', '.join(options.files)}; lengths times "
        f"{options.scale_length:g}, times times {options.scale_time:g}."
    )

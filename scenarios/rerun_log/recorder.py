"""Recording of a run for the rerun viewer.

Frames in the viewer: `world` is the scenario's world frame shifted to the ego's start, because rerun stores float32 and
SUMO's coordinates can be large. `world/ego` and `world/odom` are the ego frame and the odometry frame in it.

Rerun is imported lazily inside the functions, because its import takes half a second.
"""

import os
import shutil
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.control.ego_driver import Decision
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.grading.articulated import parts
from luxloop.scenarios.grading.frame_truth import FrameGrade
from luxloop.scenarios.rerun_log import blueprint
from luxloop.scenarios.rerun_log.archetypes import boxes, flat, rings, texts, transform, walls
from luxloop.scenarios.rerun_log.events import EventFinder
from luxloop.sensor_model.truth import NO_ACTOR, Cause, ScanTruth
from luxloop.sim.world import Actors, Ego, Mode, Obstacles, WorldFrame
from luxloop.tracker.records import MODEL_NAMES, Boxes, Status, StepTrace, Tracks
from luxloop.tracker.scan import Scan

if TYPE_CHECKING:
    import rerun as rr


def plot_values(actors: Actors, truth: ScanTruth, tracks: Tracks, grade: FrameGrade) -> dict[str, Floats]:
    """Return the values of the lines of each plot in `blueprint.PLOTS`, by entity path."""
    confirmed, coasting = tracks.status == Status.CONFIRMED, tracks.status == Status.COASTING
    moving = actors.mode != Mode.STATIONARY
    on_moving = confirmed & np.isin(grade.track_actor, actors.id[moving])
    on_standing = confirmed & np.isin(grade.track_actor, actors.id[~moving])
    fit_error, track_error = grade.box_heading_error, grade.track_heading_error[confirmed]
    probability = by_model_name(tracks)
    noise = truth.cause != Cause.CLEAN
    return {
        "plots/models_moving": _mean(probability[on_moving]),
        "plots/models_standing": _mean(probability[on_standing]),
        "plots/heading_error": np.array([_median_abs_deg(fit_error), _median_abs_deg(track_error)]),
        "plots/counts": np.array([grade.graded.sum(), confirmed.sum(), coasting.sum()]),
        "plots/points": np.array([len(noise), noise.sum()]),
    }


def by_model_name(tracks: Tracks) -> Floats:
    """(T, len(MODEL_NAMES)) model probabilities; NaN for models that are not in the filter bank."""
    probability = np.full((len(tracks), len(MODEL_NAMES)), np.nan)
    probability[:, [MODEL_NAMES.index(model) for model in tracks.models]] = tracks.model_probability
    return probability


def _mean(rows: Floats) -> Floats:
    """Return the mean row; NaN without rows, which leaves a gap in the plot."""
    return rows.mean(axis=0) if len(rows) else np.full(rows.shape[1:], np.nan)


def _median_abs_deg(angles: Floats) -> float:
    angles = angles[np.isfinite(angles)]
    return float(np.rad2deg(np.median(np.abs(angles)))) if len(angles) else np.nan


class TrackLayer:
    """Draws the tracks of each frame, and remembers their last positions for the trails."""

    def __init__(self) -> None:
        self._last_center_odom: dict[int, Floats] = {}

    def archetypes(self, tracks: Tracks) -> "dict[str, rr.AsComponents]":
        """Return what to log of one frame, by path below `world/odom`."""
        import rerun as rr

        confirmed, coasting = tracks.status == Status.CONFIRMED, tracks.status == Status.COASTING
        hues = np.array(blueprint.CYCLE)[tracks.id % len(blueprint.CYCLE)]
        colors = hues * np.where(confirmed, 1.0, blueprint.DIM)[:, None]
        short_names = np.array([*(blueprint.SHORT_NAMES[model] for model in tracks.models), ""])  # the last: `NO_MODEL`
        suffix = np.where(confirmed, short_names[tracks.model], np.where(coasting, "coasting", ""))
        named = confirmed | coasting
        rows = zip(tracks.id, suffix, named, strict=True)
        labels = [f"{track} {text}".rstrip() if shown else "" for track, text, shown in rows]
        center, yaw = tracks.center_odom, tracks.mean[:, 6]
        line_ui = np.where(confirmed, 2.5, 1.0)
        ahead = (0.5 * tracks.size[:, :1] + blueprint.NAME_GAP_M) * np.column_stack([np.cos(yaw), np.sin(yaw)])
        velocities = rr.Arrows3D(
            origins=flat(center),
            vectors=flat(np.nan_to_num(tracks.mean[:, 2:4])),
            colors=colors.astype(np.uint8),
            radii=rr.Radius.ui_points(1.0),
        )
        return {
            "tracks": boxes(np.column_stack([center, yaw]), flat(tracks.size), colors, line_ui=line_ui),
            "tracks/names": texts(center + ahead, labels),
            "velocities": velocities,
            "trails": self._trails(tracks.id, center, (blueprint.DIM * hues).astype(np.uint8)),
        }

    def _trails(self, track_id: Ints, center_odom: Floats, colors: npt.NDArray[np.uint8]) -> "rr.LineStrips3D":
        """Return the last step of each trail; the view shows the steps of the last seconds together."""
        import rerun as rr

        current = dict(zip(track_id.tolist(), flat(center_odom), strict=True))
        steps = [[self._last_center_odom.get(track, position), position] for track, position in current.items()]
        self._last_center_odom = current
        return rr.LineStrips3D(steps, colors=colors, radii=rr.Radius.ui_points(1.0))


LEAST_FREE_BYTES = 4 * 2**20
"""Free space that a recording needs at least [bytes]; a short one has 0.3 MB."""
FLUSH_S = 60.0
"""Longest wait for the last frames [s]."""
CHUNK_FRAMES = 64
"""Frames of an entity that are written together, unless they are more than rerun's largest chunk [bytes]."""
INDEXED_FRAMES = 7500
"""Longest recording with an index of its chunks, ten minutes: rerun holds the index in memory until the end."""


def _require_space(folder: Path) -> None:
    """Raise an OutputError on a disk that is almost full, on which rerun would wait for ever when it opens its file."""
    if shutil.disk_usage(folder).free < LEAST_FREE_BYTES:
        needed = f"a recording needs {LEAST_FREE_BYTES // 2**20} MB"
        raise OutputError(
            f"{folder}: cannot write there (No space left on device: {needed}); free some space, choose another "
            "folder with --out, or run with --no-recording"
        )


class NullRecorder:
    """Recorder of runs without a recording."""

    def log(self, *records: object) -> None:
        """Do nothing."""

    def finish(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


class Recorder:
    """Writes one run to an .rrd file.

    Parameters
    ----------
    path
        The file to write.
    scenario
        Name of the recording in the viewer.
    obstacles
        Static obstacles, from `TrafficSource.reset`.
    controlled
        True for a controlled ego, which has its own plot.
    frames
        Number of frames that follow. With more than `INDEXED_FRAMES` the file has no index.
    """

    def __init__(
        self, path: Path, scenario: str, obstacles: Obstacles, *, controlled: bool = False, frames: int = 0
    ) -> None:
        os.environ.setdefault("RUST_LOG", "off")  # before the import: rerun prints errors that `finish` raises
        import rerun as rr

        _require_space(path.parent)
        self._path = path
        self._obstacles = obstacles
        self._origin_world: Floats | None = None
        self._track_layer = TrackLayer()
        self._events = EventFinder()
        self._stream = rr.RecordingStream("luxloop", batcher_config=_chunks_of_frames())
        self._stream.set_log_time_enabled(False)
        layout = blueprint.layout(controlled=controlled)
        self._stream.save(path, default_blueprint=layout, write_footer=frames <= INDEXED_FRAMES)
        self._stream.send_recording_name(scenario)

    def log(
        self,
        frame: WorldFrame,
        scan: Scan,
        scan_truth: ScanTruth,
        tracks: Tracks,
        trace: StepTrace | None,
        grade: FrameGrade,
        decision: Decision | None = None,
    ) -> None:
        """Write one frame.

        Parameters
        ----------
        trace
            Intermediate results of the tracker, or None if it does not return them.
        decision
            Decision of the ego's controller, or None without one.
        """
        import rerun as rr

        if self._origin_world is None:
            self._origin_world = np.append(frame.ego.pose_world[:2], 0.0)
            self._log_static(frame.ego, self._origin_world)
        self._stream.set_time("frame", sequence=frame.index)
        self._stream.set_time("sim_time", duration=frame.time)
        ego_pose = frame.ego.pose_world - self._origin_world
        self._stream.log("world/ego", transform(ego_pose))
        self._stream.log("world/odom", transform(_odom_pose(ego_pose, scan.ego_pose_odom)))
        actor_pose = frame.actors.pose_world - self._origin_world
        self._log_truth(frame.actors, actor_pose, scan_truth.visible_fraction, grade.graded)
        self._log_points(scan, scan_truth)
        if trace is not None:
            self._log_fits(trace.boxes)
        for path, shape in self._track_layer.archetypes(tracks).items():
            self._stream.log(f"world/odom/{path}", shape)
        for path, values in plot_values(frame.actors, scan_truth, tracks, grade).items():
            self._stream.log(path, rr.Scalars(values))
        self._log_events(frame, tracks, grade)
        if decision is not None:
            self._log_control(frame.ego, decision)

    def finish(self) -> None:
        """Wait until all frames are in the file.

        Raises
        ------
        OutputError
            The file cannot be written: rerun writes it in a thread of its own, which ends at the first error.
        """
        try:
            self._stream.flush(timeout_sec=FLUSH_S)
        except (RuntimeError, ValueError) as error:
            raise OutputError(
                f"{self._path}: the recording cannot be written ({error}); the disk may be full: free some space, or "
                "run with --no-recording"
            ) from error

    def close(self) -> None:
        """Flush and close the file. A second call has no effect."""
        self._stream.disconnect()

    def _log_static(self, ego: Ego, origin_world: Floats) -> None:
        import rerun as rr

        body = boxes(np.zeros((1, 3)), ego.size[None], blueprint.WHITE, labels=["ego"], solid=True)
        buildings = walls(self._obstacles, origin_world[:2], blueprint.WALL_TOP_M, blueprint.DARK)
        legend = rr.TextDocument(blueprint.LEGEND, media_type=rr.MediaType.MARKDOWN)
        self._stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, blueprint.point_classes(), static=True)
        self._stream.log("world/obstacles", buildings, static=True)
        self._stream.log("world/ego/body", body, static=True)
        self._stream.log("world/ego/rings", rings(blueprint.RINGS_M, blueprint.DARK), static=True)
        self._stream.log("legend", legend, static=True)
        for path, lines in {**blueprint.PLOTS, blueprint.CONTROL: blueprint.CONTROL_LINES}.items():
            style = rr.SeriesLines(names=list(lines), colors=list(lines.values()), widths=1.5)
            self._stream.log(path, style, static=True)

    def _log_truth(self, actors: Actors, pose: Floats, visible: Floats, graded: Bools) -> None:
        hidden_color, visible_color = np.array(blueprint.HIDDEN), np.array(blueprint.VISIBLE)
        colors = hidden_color + visible[:, None] * (visible_color - hidden_color)
        colors = colors * np.where(graded, 1.0, blueprint.DIM)[:, None]
        row, pose, size = parts(pose, actors.size, actors.joint_angles, actors.kind)
        names = [str(name) for name in actors.name[row]]
        self._stream.log("world/truth", boxes(pose, size, colors[row], labels=names, show_labels=False))

    def _log_points(self, scan: Scan, truth: ScanTruth) -> None:
        import rerun as rr

        background = (truth.actor_id == NO_ACTOR) & (truth.cause == Cause.CLEAN)
        cause = np.where(background, blueprint.BACKGROUND, truth.cause)
        radii = rr.Radius.ui_points(np.where(truth.cause == Cause.CLEAN, 1.5, 2.5))
        points = rr.Points3D(scan.points_ego, class_ids=cause, radii=radii)
        # One set of positions with three colourings. A view can use another component's colours, but not class ids.
        cycle = np.array(blueprint.CYCLE, np.uint8)
        colorings = {
            "unit": rr.components.ColorBatch(cycle[scan.unit % len(cycle)]),
            "layer": rr.components.ColorBatch(cycle[scan.layer % len(cycle)]),
        }
        self._stream.log("world/ego/points", points, rr.DynamicArchetype("by", components=colorings))

    def _log_fits(self, fits: Boxes) -> None:
        pose = np.column_stack([fits.center_ego, fits.heading])
        self._stream.log("world/ego/fits", boxes(pose, flat(fits.size), blueprint.YELLOW))

    def _log_control(self, ego: Ego, decision: Decision) -> None:
        import rerun as rr

        speed = float(np.linalg.norm(ego.velocity_world))
        gap = decision.lead.gap if decision.lead else np.nan
        self._stream.log(blueprint.CONTROL, rr.Scalars([speed, decision.speed_mps, gap]))

    def _log_events(self, frame: WorldFrame, tracks: Tracks, grade: FrameGrade) -> None:
        import rerun as rr

        for found in grade.events:
            self._stream.log("events", rr.TextLog(f"truth: {found.text}", level="WARN"))
        for event in self._events.update(frame, tracks, grade):
            self._stream.log("events", rr.TextLog(event.text, level=event.level))


def _chunks_of_frames() -> "rr.ChunkBatcherConfig":
    """Return thresholds of rerun's chunks in frames, not in wall time: a slow run has as many chunks as a fast one."""
    import rerun as rr

    config = rr.ChunkBatcherConfig.DEFAULT()
    config.flush_num_rows = CHUNK_FRAMES
    config.flush_tick = timedelta(days=1)  # never
    return config


def _odom_pose(ego_pose: Floats, ego_pose_odom: Floats) -> Floats:
    """Return the pose (3,) of the odometry frame in the frame of `ego_pose`, from the ego's pose in both."""
    yaw = ego_pose[2] - ego_pose_odom[2]
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    return np.append(ego_pose[:2] - turn @ ego_pose_odom[:2], yaw)

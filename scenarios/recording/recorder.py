"""The recording of a run for the rerun viewer.

Frames in the viewer: `world` is the scenario's world frame shifted to where the ego started, since rerun stores
float32 and SUMO's coordinates can be large. `world/ego` and `world/odom` are the ego and the odometry frame in it.
Rerun takes half a second to import, so the functions that need it import it.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenarios.arrays import Bools, Floats, Ints
from scenarios.control.cruise import Decision
from scenarios.grading.articulated import parts
from scenarios.grading.frame_grade import FrameGrade
from scenarios.recording import blueprint as look
from scenarios.recording.archetypes import boxes, flat, rings, texts, transform, walls
from scenarios.recording.events import EventFinder
from sensor_model.truth import NO_ACTOR, Cause, ScanTruth
from sim.world import Actors, Ego, Mode, Obstacles, WorldFrame
from tracker.records import Boxes, Status, StepTrace, Tracks
from tracker.scan import Scan


class NullRecorder:
    """Records nothing, for runs that want no recording."""

    def log(self, *records: object) -> None:
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
        The recording's name in the viewer.
    obstacles
        What `TrafficSource.reset` returned.
    controlled
        Whether the ego is.
    """

    def __init__(self, path: Path, scenario: str, obstacles: Obstacles, *, controlled: bool = False) -> None:
        import rerun as rr

        self._obstacles = obstacles
        self._origin_world: Floats | None = None
        self._last_center_odom: dict[int, Floats] = {}
        self._events = EventFinder()
        self._stream = rr.RecordingStream("luxloop")
        self._stream.set_log_time_enabled(False)
        self._stream.save(path, default_blueprint=look.layout(controlled=controlled))
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

        `trace` is None for a tracker that does not tell what it did, `decision` where no controller made one.
        """
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
        self._log_tracks(tracks)
        self._log_plots(frame.actors, scan_truth, tracks, grade)
        self._log_events(frame, tracks, grade)
        if decision is not None:
            self._log_control(frame.ego, decision)

    def close(self) -> None:
        """Flush and finish the file. Safe to call twice."""
        self._stream.disconnect()

    def _log_static(self, ego: Ego, origin_world: Floats) -> None:
        import rerun as rr

        body = boxes(np.zeros((1, 3)), ego.size[None], look.WHITE, labels=["ego"], solid=True)
        buildings = walls(self._obstacles, origin_world[:2], look.WALL_TOP_M, look.DARK)
        legend = rr.TextDocument(look.LEGEND, media_type=rr.MediaType.MARKDOWN)
        self._stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, look.point_classes(), static=True)
        self._stream.log("world/obstacles", buildings, static=True)
        self._stream.log("world/ego/body", body, static=True)
        self._stream.log("world/ego/rings", rings(look.RINGS_M, look.DARK), static=True)
        self._stream.log("legend", legend, static=True)
        for path, lines in {**look.PLOTS, look.CONTROL: look.CONTROL_LINES}.items():
            style = rr.SeriesLines(names=list(lines), colors=list(lines.values()), widths=1.5)
            self._stream.log(path, style, static=True)

    def _log_truth(self, actors: Actors, pose: Floats, visible: Floats, graded: Bools) -> None:
        hidden_color, visible_color = np.array(look.HIDDEN), np.array(look.VISIBLE)
        colors = hidden_color + visible[:, None] * (visible_color - hidden_color)
        colors = colors * np.where(graded, 1.0, look.DIM)[:, None]
        row, pose, size = parts(pose, actors.size, actors.articulation)
        names = [str(name) for name in actors.name[row]]
        self._stream.log("world/truth", boxes(pose, size, colors[row], labels=names, show_labels=False))

    def _log_points(self, scan: Scan, truth: ScanTruth) -> None:
        import rerun as rr

        background = (truth.actor_id == NO_ACTOR) & (truth.cause == Cause.CLEAN)
        cause = np.where(background, look.BACKGROUND, truth.cause)
        radii = rr.Radius.ui_points(np.where(truth.cause == Cause.CLEAN, 1.5, 2.5))
        points = rr.Points3D(scan.points_ego, class_ids=cause, radii=radii)
        # One set of positions, three colourings: a view can take colours, but not class ids, from another component.
        cycle = np.array(look.CYCLE, np.uint8)
        colorings = {
            "unit": rr.components.ColorBatch(cycle[scan.unit % len(cycle)]),
            "layer": rr.components.ColorBatch(cycle[scan.layer % len(cycle)]),
        }
        self._stream.log("world/ego/points", points, rr.DynamicArchetype("by", components=colorings))

    def _log_fits(self, fits: Boxes) -> None:
        pose = np.column_stack([fits.center_ego, fits.heading])
        self._stream.log("world/ego/fits", boxes(pose, flat(fits.size), look.YELLOW))

    def _log_tracks(self, tracks: Tracks) -> None:
        import rerun as rr

        confirmed, coasting = tracks.status == Status.CONFIRMED, tracks.status == Status.COASTING
        hues = np.array(look.CYCLE)[tracks.id % len(look.CYCLE)]
        colors = hues * np.where(confirmed, 1.0, look.DIM)[:, None]
        remark = np.where(confirmed, np.array(look.MODEL_NAMES)[tracks.model], np.where(coasting, "coasting", ""))
        labels = [f"{track} {text}" if text else "" for track, text in zip(tracks.id, remark, strict=True)]
        center, yaw = tracks.center_odom, tracks.mean[:, 6]
        line_ui = np.where(confirmed, 2.5, 1.0)
        rectangles = boxes(np.column_stack([center, yaw]), flat(tracks.size), colors, line_ui=line_ui)
        ahead = (0.5 * tracks.size[:, :1] + look.NAME_GAP_M) * np.column_stack([np.cos(yaw), np.sin(yaw)])
        arrows = rr.Arrows3D(
            origins=flat(center),
            vectors=flat(tracks.mean[:, 2:4]),
            colors=colors.astype(np.uint8),
            radii=rr.Radius.ui_points(1.0),
        )
        self._stream.log("world/odom/tracks", rectangles)
        self._stream.log("world/odom/tracks/names", texts(center + ahead, labels, colors))
        self._stream.log("world/odom/velocities", arrows)
        self._log_trails(tracks.id, center, (look.DIM * hues).astype(np.uint8))

    def _log_trails(self, track_id: Ints, center_odom: Floats, colors: npt.NDArray[np.uint8]) -> None:
        """Write one step of each trail: the view shows the steps of the last seconds together."""
        import rerun as rr

        now = dict(zip(track_id.tolist(), flat(center_odom), strict=True))
        steps = [[self._last_center_odom.get(track, at), at] for track, at in now.items()]
        self._last_center_odom = now
        trails = rr.LineStrips3D(steps, colors=colors, radii=rr.Radius.ui_points(1.0))
        self._stream.log("world/odom/trails", trails)

    def _log_plots(self, actors: Actors, truth: ScanTruth, tracks: Tracks, grade: FrameGrade) -> None:
        import rerun as rr

        confirmed, coasting = tracks.status == Status.CONFIRMED, tracks.status == Status.COASTING
        moving = actors.mode != Mode.STATIONARY
        on_moving = confirmed & np.isin(grade.track_actor, actors.id[moving])
        on_standing = confirmed & np.isin(grade.track_actor, actors.id[~moving])
        fit_error, track_error = grade.box_heading_error, grade.track_heading_error[confirmed]
        noise = truth.cause != Cause.CLEAN
        values = {
            "plots/models_moving": _mean(tracks.model_probability[on_moving]),
            "plots/models_standing": _mean(tracks.model_probability[on_standing]),
            "plots/heading_error": np.array([_median_abs_deg(fit_error), _median_abs_deg(track_error)]),
            "plots/counts": np.array([grade.graded.sum(), confirmed.sum(), coasting.sum()]),
            "plots/points": np.array([len(noise), noise.sum()]),
        }
        for path, lines in values.items():
            self._stream.log(path, rr.Scalars(lines))

    def _log_control(self, ego: Ego, decision: Decision) -> None:
        import rerun as rr

        speed = float(np.linalg.norm(ego.velocity_world))
        gap = decision.lead.gap if decision.lead else np.nan
        self._stream.log(look.CONTROL, rr.Scalars([speed, decision.speed_mps, gap]))

    def _log_events(self, frame: WorldFrame, tracks: Tracks, grade: FrameGrade) -> None:
        import rerun as rr

        for event in self._events.update(frame, tracks, grade):
            self._stream.log("events", rr.TextLog(event.text, level=event.level))


def _odom_pose(ego_pose: Floats, ego_pose_odom: Floats) -> Floats:
    """Return the pose (3,) of the odometry frame in the frame of `ego_pose`, given the ego in both."""
    yaw = ego_pose[2] - ego_pose_odom[2]
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    return np.append(ego_pose[:2] - turn @ ego_pose_odom[:2], yaw)


def _mean(rows: Floats) -> Floats:
    """Return the mean row, NaN where there are none: a gap in the plot."""
    return rows.mean(axis=0) if len(rows) else np.full(rows.shape[1:], np.nan)


def _median_abs_deg(angles: Floats) -> float:
    angles = angles[np.isfinite(angles)]
    return float(np.rad2deg(np.median(np.abs(angles)))) if len(angles) else np.nan

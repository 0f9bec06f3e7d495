"""Closed-loop drives of the ego: driver on the tracks or on the ground truth, and the safety of the drives.

The speed is that of the Intelligent Driver Model: Treiber, Hennecke and Helbing,
"Congested traffic states in empirical observations and microscopic simulations",
Physical Review E 62 (2000) 1805.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from luxloop import elementary, elementwise
from luxloop.arrays import Floats, Ints
from luxloop.scenarios.control.control_config import CruiseConfig
from luxloop.scenarios.grading.articulated import parts
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner, into_frame, iou_table, turned, wrap
from luxloop.scenarios.grading.track_matches import track_boxes
from luxloop.scenarios.metrics.definitions import DRIVERS, SAFETY
from luxloop.scenarios.result import Metric
from luxloop.sim.source import EgoCommand, TrafficSource
from luxloop.sim.world import Ego, WorldFrame
from luxloop.tracker.records import Status, Tracks
from luxloop.tracker.scan import Scan

NO_CONTROL = "the scenario has no [control]: the traffic model drives the ego"
NO_LEAD = "there was no lead vehicle"
NEVER_CLOSING = "the ego was never faster than its lead vehicle"
NO_FRAME = "the drive ended before its first frame"

COLUMNS = (
    "frame", "time_s", "speed_mps", "acceleration_mps2", "wanted_mps", "gap_m", "closing_mps", "ttc_s", "collides",
)  # fmt: skip
"""Columns of the table, which has one row per frame and drive; a column `driver` is appended."""


class SafetyLog:
    """Records the ground truth of a drive, frame by frame.

    The lead vehicle is the nearest one in the corridor that the ego's body will cover at its present curvature. The
    time to collision is the gap divided by the closing speed (Hayward, "Near-miss determination through use of a scale
    of danger", Highway Research Record 384, 1972); it is undefined if the gap does not close.
    """

    def __init__(self) -> None:
        self._rows: list[tuple[Any, ...]] = []
        self._hit: set[int] = set()

    def add(self, frame: WorldFrame, wanted_mps: float | None) -> None:
        """Record the next frame, and the speed commanded in it, if any."""
        ego, around = frame.ego, true_surroundings(frame)
        lead = find_lead(around, half_width_m=0.5 * float(ego.size[1]))
        body = np.array([[0.0, 0.0, 0.0, *ego.size[:2]]])
        overlaps = iou_table(body, around.boxes_ego)[0] > 0
        self._hit.update(around.id[overlaps].tolist())
        gap, closing = (lead.gap, around.speed - lead.speed) if lead else (np.nan, np.nan)
        ttc = max(gap, 0.0) / closing if closing > 0 else np.nan
        acceleration = turned(ego.acceleration_world, -ego.pose_world[2])[0]
        wanted = np.nan if wanted_mps is None else wanted_mps
        row = (frame.index, frame.time, around.speed, acceleration, wanted, gap, closing, ttc, overlaps.any())
        self._rows.append(row)

    def table(self) -> pd.DataFrame:
        """Return one row per frame; NaN without a lead vehicle, without a closing gap, and before the first command."""
        return pd.DataFrame(self._rows, columns=list(COLUMNS))

    def collisions(self) -> int:
        """Return the number of actors whose box ever overlapped the ego's box."""
        return len(self._hit)


def grade(drives: Mapping[str, SafetyLog]) -> tuple[dict[str, Metric], dict[str, pd.DataFrame]]:
    """Return every metric of `kind `control`` and their table, from the logs by driver; a log may be missing."""
    sheet, tables = MetricSheet(), []
    for driver, prefix in DRIVERS.items():
        if (log := drives.get(driver)) is not None:
            tables.append(log.table().assign(driver=driver))
            _write(sheet, prefix, tables[-1], log.collisions())
        else:
            _write_none(sheet, prefix)
    return sheet.metrics, {"control": pd.concat(tables, ignore_index=True)} if tables else {}


def _write(sheet: MetricSheet, prefix: str, table: pd.DataFrame, collisions: int) -> None:
    frames, gap, ttc = len(table), table["gap_m"].dropna(), table["ttc_s"].dropna()
    braking = -table["acceleration_mps2"]
    why = NEVER_CLOSING if len(gap) else NO_LEAD
    sheet.write(f"control.{prefix}min_ttc_s", ttc.min(), len(ttc), why)
    sheet.write(f"control.{prefix}min_gap_m", gap.min(), len(gap), NO_LEAD)
    sheet.write(f"control.{prefix}max_deceleration_mps2", max(braking.max(), 0.0), frames, NO_FRAME)
    sheet.write(f"control.{prefix}collisions", float(collisions), frames, NO_FRAME)


def _write_none(sheet: MetricSheet, prefix: str) -> None:
    for name in SAFETY:
        sheet.write(f"control.{prefix}{name}", None, 0, NO_CONTROL)


_VELOCITY = slice(2, 4)
"""Components of the velocity in `Tracks.mean`."""


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """Ego motion, and N objects in the ego frame."""

    speed: float
    """[m/s] Speed of the ego along its heading, negative backwards."""
    yaw_rate: float
    """[rad/s] Yaw rate of the ego."""
    front_m: float
    """[m] Distance from the ego's centre to its front bumper."""
    id: Ints
    """(N,) id of the track or the actor; an articulated truck has two boxes."""
    boxes_ego: Floats
    """(N, 5) x, y [m], yaw [rad], length, width [m]."""
    velocity_ego: Floats
    """(N, 2) velocity over ground [m/s], on the ego's axes."""


class TrackedSurroundings:
    """Surroundings from the confirmed tracks; coasting tracks are predictions and are ignored.

    A track without a velocity is taken to stand, which makes the ego brake.

    Parameters
    ----------
    dt
        Time between frames [s].
    """

    def __init__(self, dt: float):
        self._dt = dt
        self._last_pose_odom: Floats | None = None

    def observe(self, ego: Ego, scan: Scan, tracks: Tracks) -> Surroundings | None:
        """Return the surroundings; None at the first scan, since a speed needs two poses.

        Only the size of `ego` is used.
        """
        last, now = self._last_pose_odom, scan.ego_pose_odom
        self._last_pose_odom = now
        if last is None:
            return None
        change = wrap(now[2] - last[2])
        step = turned(now[:2] - last[:2], -(last[2] + 0.5 * change))
        row = np.flatnonzero(tracks.status == Status.CONFIRMED)
        return Surroundings(
            speed=float(step[0]) / self._dt,
            yaw_rate=float(change) / self._dt,
            front_m=0.5 * float(ego.size[0]),
            id=tracks.id[row],
            boxes_ego=track_boxes(tracks, now)[row],
            velocity_ego=turned(np.nan_to_num(tracks.mean[row, _VELOCITY]), -now[2]),
        )


def true_surroundings(frame: WorldFrame) -> Surroundings:
    """Return the surroundings from the ground truth."""
    ego, actors = frame.ego, frame.actors
    row, pose_world, size = parts(actors.pose_world, actors.size[:, :2], actors.joint_angles, actors.kind)
    return Surroundings(
        speed=float(turned(ego.velocity_world, -ego.pose_world[2])[0]),
        yaw_rate=ego.yaw_rate,
        front_m=0.5 * float(ego.size[0]),
        id=actors.id[row],
        boxes_ego=np.column_stack([into_frame(pose_world, ego.pose_world), size]),
        velocity_ego=turned(actors.velocity_world[row], -ego.pose_world[2]),
    )


_MIN_SPEED = 1.0
"""[m/s] Lower bound of the speed in curvature = yaw rate / speed, which is undefined at standstill."""
_STRAIGHT = 1e-6
"""[1/m] Curvature below which the path is taken as straight."""


@dataclass(frozen=True, slots=True)
class LeadVehicle:
    """The lead vehicle."""

    id: int
    """Id of its track, or of the actor."""
    gap: float
    """[m] Gap along the path, from the ego's front bumper to its nearest point in the corridor; negative in a crash."""
    speed: float
    """[m/s] Speed along the path."""


def find_lead(around: Surroundings, half_width_m: float) -> LeadVehicle | None:
    """Return the lead vehicle in a corridor of this half width [m], or None.

    Only objects whose centre is in front of the ego's centre are considered.
    """
    curvature = around.yaw_rate / max(abs(around.speed), _MIN_SPEED)
    center = to_path_frame(around.boxes_ego[:, :2], curvature)
    corners = to_path_frame(corner(around.boxes_ego[:, None], CORNER_SIGNS), curvature)
    near = np.where(center[:, 0] > 0, nearest_in_corridor(corners, half_width_m), np.inf)
    if not np.isfinite(near).any():
        return None
    row = int(np.argmin(near))
    path_heading = curvature * center[row, 0]
    v_x, v_y = around.velocity_ego[row].tolist()
    speed = v_x * elementary.cos(path_heading) + v_y * elementary.sin(path_heading)
    return LeadVehicle(int(around.id[row]), float(near[row]) - around.front_m, speed)


def to_path_frame(points_ego: Floats, curvature: float) -> Floats:
    """Return points (..., 2) [m] as (arc length along the path, offset to its left) from the ego's centre.

    The path is an arc of constant curvature k [1/m], positive to the left. A point with arc length s and offset d is at
    x = sin(k s) (1/k - d), y = 1/k - cos(k s) (1/k - d).
    """
    if abs(curvature) < _STRAIGHT:
        return points_ego
    sine, cosine = curvature * points_ego[..., 0], 1.0 - curvature * points_ego[..., 1]
    return np.stack([elementwise.atan2(sine, cosine), 1.0 - elementwise.hypot(sine, cosine)], axis=-1) / curvature


def nearest_in_corridor(corners: Floats, half_width_m: float) -> Floats:
    """Return the smallest arc length (N,) of outlines (N, 4, 2) inside the corridor; infinite for those outside.

    The minimum is at a corner inside the corridor, or where an edge crosses one of its borders.
    """
    after = np.roll(corners, -1, axis=1)
    arc, offset = corners[..., 0], corners[..., 1]
    at = [np.where(np.abs(offset) <= half_width_m, arc, np.inf)]
    rise = after[..., 1] - offset
    for border in (-half_width_m, half_width_m):
        part = (border - offset) / np.where(rise == 0, np.nan, rise)
        crosses = (part >= 0) & (part <= 1)
        at.append(np.where(crosses, arc + np.where(crosses, part, 0.0) * (after[..., 0] - arc), np.inf))
    return np.asarray(np.min(at, axis=(0, 2)))


_EXPONENT = 4
"""delta of the model: exponent of the acceleration's decrease towards the set speed."""
_MIN_GAP = 0.1
"""[m] Lower bound of the gap, by which the model divides."""
_MAX_EXCESS = 3.0
"""[m/s] Anti-windup: maximum excess of the commanded over the actual speed, e.g. at a speed limit."""


@dataclass(frozen=True, slots=True)
class Decision:
    """Output of the controller for one frame."""

    speed_mps: float
    """[m/s] Commanded speed at the next frame."""
    lead: LeadVehicle | None
    """Lead vehicle, if any."""


def idm_acceleration(speed: float, lead: LeadVehicle | None, config: CruiseConfig) -> float:
    """Return the acceleration [m/s^2] by equations (2) and (3) of the paper, limited to the maximum deceleration.

    a [1 - (v/v0)^4 - (s*/s)^2] with s* = s0 + max(0, v T + v (v - v_lead) / (2 sqrt(a b))).
    """
    a, b = config.acceleration_mps2, config.comfortable_deceleration_mps2
    usage = (speed / config.set_speed_mps) ** _EXPONENT
    if lead is not None:
        dynamic = speed * config.time_gap_s + speed * (speed - lead.speed) / (2.0 * math.sqrt(a * b))
        usage += ((config.standstill_gap_m + max(0.0, dynamic)) / max(lead.gap, _MIN_GAP)) ** 2
    return max(a * (1.0 - usage), -config.max_deceleration_mps2)


class CruiseController:
    """Integrates the model's acceleration to the commanded speed.

    Parameters
    ----------
    config
        Parameters of the controller.
    dt
        Time between decisions [s].
    """

    def __init__(self, config: CruiseConfig, dt: float):
        self._config = config
        self._dt = dt
        self._commanded: float | None = None

    def decide(self, around: Surroundings) -> Decision:
        """Return the command for the next frame."""
        lead = find_lead(around, self._config.corridor_half_width_m)
        speed = max(around.speed, 0.0)
        before = speed if self._commanded is None else self._commanded
        commanded = before + idm_acceleration(speed, lead, self._config) * self._dt
        self._commanded = min(max(commanded, 0.0), speed + _MAX_EXCESS)
        return Decision(self._commanded, lead)


class TrackDriver:
    """Drives the ego on the confirmed tracks.

    Parameters
    ----------
    config
        Parameters of the controller.
    source
        Traffic source that executes the commands.
    """

    def __init__(self, config: CruiseConfig, source: TrafficSource):
        self._source = source
        self._surroundings = TrackedSurroundings(source.dt)
        self._controller = CruiseController(config, source.dt)
        self.log = SafetyLog()

    def drive(self, frame: WorldFrame, scan: Scan, tracks: Tracks) -> Decision | None:
        """Command the ego for the next frame; None at the first scan, before the speed is known.

        The ground truth `frame` is only logged, except for the size of the ego.
        """
        around = self._surroundings.observe(frame.ego, scan, tracks)
        decision = self._controller.decide(around) if around else None
        if decision:
            self._source.apply(EgoCommand(speed_mps=decision.speed_mps))
        self.log.add(frame, decision.speed_mps if decision else None)
        return decision


def drive_by_truth(config: CruiseConfig, source: TrafficSource, log: SafetyLog, frames: int) -> None:
    """Drive a freshly reset source for a number of frames on the ground truth, without sensor and tracker."""
    controller = CruiseController(config, source.dt)
    for _ in range(frames):
        frame = source.step()
        decision = controller.decide(true_surroundings(frame))
        source.apply(EgoCommand(speed_mps=decision.speed_mps))
        log.add(frame, decision.speed_mps)

"""Emergence of a target: first beam, points, fit, track and confirmation, with the time to a collision."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.frame_tables import rows_by_actor
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.plane_geometry import turned, wrap
from luxloop.scenarios.grading.track_matches import TrackMatches
from luxloop.scenarios.metrics.definitions import EMERGING, END, MEASURES, STAGES, SURVIVAL
from luxloop.sim.world import Kind
from luxloop.tracker.records import Status, Tracks


def survival(times: Floats, reached: Bools) -> tuple[Floats, Floats]:
    """Return the product-limit estimate of the survival function (Kaplan and Meier 1958).

    Parameters
    ----------
    times
        (N,) time of each event, or of the end of the observation without one.
    reached
        (N,) True for events, False for censored times.

    Returns
    -------
    tuple of arrays
        (K,) distinct times in ascending order, and the share of events that come later (K,).
    """
    at, number = np.unique(times, return_inverse=True)
    events = np.bincount(number, reached, len(at))
    observed = len(times) - np.searchsorted(np.sort(times), at)  # events and censored times from this one on
    return at, np.asarray(np.cumprod(1.0 - events / observed), np.float64)


def median(times: Floats, reached: Bools) -> float:
    """Return the least time at which half of the events have happened; infinite if the estimate stays above."""
    if not len(times):
        return math.inf
    at, share = survival(times, reached)
    half = np.flatnonzero(share <= 0.5 + 1e-12)
    return float(at[half[0]]) if len(half) else math.inf


ROUNDING_MPS = 1e-9
"""[m/s] Speeds below this are rounding errors of equal velocities; a metre would take 30 years."""


def time_to_collision(a: Floats, velocity_a: Floats, b: Floats, velocity_b: Floats) -> Floats:
    """Return the time until two boxes touch, if both keep velocity and heading.

    Two rectangles overlap if their projections overlap on each of their four axes (separating axis theorem). On each
    axis the projections of moving boxes overlap during one interval of time, and the boxes during the common part.

    Parameters
    ----------
    a, b
        (N, 5) boxes: x [m], y [m], yaw [rad], length [m], width [m].
    velocity_a, velocity_b
        (N, 2) velocities in the same frame [m/s].

    Returns
    -------
    (N,) time [s]; 0 for boxes that overlap, infinite for those that never will.
    """
    begin, end = np.full(len(a), -np.inf), np.full(len(a), np.inf)
    for yaw in (a[:, 2], a[:, 2] + 0.5 * np.pi, b[:, 2], b[:, 2] + 0.5 * np.pi):
        distance = turned(b[:, :2] - a[:, :2], -yaw)[:, 0]
        speed = turned(velocity_b - velocity_a, -yaw)[:, 0]
        reach = _half_extent(a, yaw) + _half_extent(b, yaw)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossings = np.sort([(-reach - distance) / speed, (reach - distance) / speed], axis=0)
        resting = np.abs(speed) < ROUNDING_MPS
        always = np.where(np.abs(distance) < reach, np.inf, -np.inf)
        begin = np.maximum(begin, np.where(resting, -always, crossings[0]))
        end = np.minimum(end, np.where(resting, always, crossings[1]))
    return np.where((begin < end) & (end > 0.0), np.maximum(begin, 0.0), np.inf)


def _half_extent(boxes: Floats, yaw: Floats) -> Floats:
    """(N,) half extents of boxes (N, 5) along axes with the angles `yaw` (N,) [m]."""
    turn = boxes[:, 2] - yaw
    half: Floats = 0.5 * (boxes[:, 3] * np.abs(np.cos(turn)) + boxes[:, 4] * np.abs(np.sin(turn)))
    return half


NO_MEETING = (np.nan, np.nan)

AHEAD_S = 1.0
"""[s] Continuation of an actor's path, which ends with the run, perhaps in front of the ego."""


class EgoPath(NamedTuple):
    """Path of the ego's front over F frames."""

    time_s: Floats
    """(F,) [s]."""
    front: Floats
    """(F, 2) middle of the front in the world frame [m]."""
    along_m: Floats
    """(F,) distance driven by the front since the first frame [m]."""
    width_m: float

    @classmethod
    def of(cls, time_s: Floats, boxes: Floats) -> "EgoPath":
        """Return the path of boxes (F, 5): x, y, yaw, length, width."""
        heading = np.column_stack([np.cos(boxes[:, 2]), np.sin(boxes[:, 2])])
        front = boxes[:, :2] + 0.5 * boxes[:, 3:4] * heading
        steps = np.hypot(*np.diff(front, axis=0, prepend=front[:1]).T)
        return cls(time_s, front, np.cumsum(steps), float(boxes[0, 4]))

    def meeting(self, boxes: Floats, last_mps: float) -> tuple[float, float]:
        """Return time [s] and distance driven [m] at which the front is at the meeting point with an actor.

        The meeting point is the first point of the front's path that is not farther from the actor's path than half the
        sum of both widths, whenever the actor is there. The actor's path begins at its rear in the first frame and ends
        at its front in the last, moved straight ahead by `AHEAD_S` at its last speed. There is no meeting point (NaN,
        NaN) if the paths do not come so close, or are so close from the first frame on.

        Parameters
        ----------
        boxes
            (K, 5) boxes of the actor in time order.
        last_mps
            Its last speed [m/s].
        """
        reach = 0.5 * (self.width_m + boxes[0, 4])
        moved = np.diff(self.along_m, prepend=-1.0) > 0.0
        distance_m = _distances(_path(boxes, AHEAD_S * last_mps), self.front[moved])[np.cumsum(moved) - 1]
        near = np.flatnonzero(distance_m <= reach)
        if not len(near) or near[0] == 0:
            return NO_MEETING
        frames = near[0] + np.array([-1, 0])
        before, after = distance_m[frames]
        share = (before - reach) / (before - after)
        time_s, along_m = (column[frames] @ (1.0 - share, share) for column in (self.time_s, self.along_m))
        return float(time_s), float(along_m)


def _path(boxes: Floats, ahead_m: float) -> Floats:
    """(P, 2) places on the centre's path of boxes (K, 5), from the first's rear to the last's front and farther.

    A place where the actor stands is there once.
    """
    heading = np.column_stack([np.cos(boxes[:, 2]), np.sin(boxes[:, 2])])
    half_m = 0.5 * boxes[0, 3]
    rear, front = boxes[0, :2] - half_m * heading[0], boxes[-1, :2] + (half_m + ahead_m) * heading[-1]
    path = np.vstack([rear, boxes[:, :2], front])
    moves = np.any(np.diff(path, axis=0), axis=1)
    return np.asarray(path[np.append(True, moves)])


def _distances(path: Floats, points: Floats) -> Floats:
    """(N,) distances of points (N, 2) from a polyline (P, 2) with steps [m]."""
    (start_x, start_y), (step_x, step_y) = path[:-1].T, np.diff(path, axis=0).T
    length_squared = step_x**2 + step_y**2
    x, y = points[:, :1] - start_x, points[:, 1:] - start_y
    along = x * step_x + y * step_y
    share = np.clip(along / length_squared, 0.0, 1.0)
    return np.asarray(np.hypot(x - share * step_x, y - share * step_y).min(axis=1))


NO_ROW = -1


class EmergenceLog:
    """Records, frame by frame, which actors reach a stage for the first time.

    A track is on at most one actor: the one that it follows; or else, of those that it overlaps by `match_iou_min` or
    more, the one of the largest overlap; or else the nearest one whose centre is inside its box. The last rule is for
    people, who are much smaller than any box of a vehicle tracker. Coasting and dead tracks are on no actor. No track
    is on an actor before the first beam from it, because a box beside it may reach over a hidden actor.
    """

    def __init__(self, config: GradingConfig) -> None:
        self._config = config
        self.first: dict[str, dict[int, int]] = {stage: {} for stage in STAGES}
        """Frame index by actor id, for each stage that it has reached."""

    def add(self, frame_truth: FrameTruth, matches: TrackMatches, tracks: Tracks) -> None:
        """Record one frame."""
        row = _actor_rows(frame_truth, matches, tracks, self._config.match_iou_min)
        confirmed = tracks.status == Status.CONFIRMED
        reached = {
            "first_beam": np.flatnonzero(frame_truth.points > 0),
            "enough_points": np.flatnonzero(frame_truth.points >= self._config.points_min),
            "tentative": row,
            "confirmed": row[confirmed],
            "located": row[confirmed & self._located(frame_truth, matches.boxes_ego, row)],
        }
        seen = self.first["first_beam"]
        for stage, rows in reached.items():  # the first beam comes first
            for actor in frame_truth.actors.id[rows[rows != NO_ROW]].tolist():
                if stage == "first_beam" or actor in seen:
                    self.first[stage].setdefault(actor, frame_truth.frame.index)

    def _located(self, frame_truth: FrameTruth, boxes_ego: Floats, row: Ints) -> Bools:
        """(T,) mask of boxes (T, 5) near the pose of their actor (T,). The heading of people does not count."""
        located = np.zeros(len(row), np.bool_)
        on = np.flatnonzero(row != NO_ROW)
        error = boxes_ego[on, :3] - frame_truth.boxes_ego[row[on], :3]
        is_person = frame_truth.actors.kind[row[on]] == Kind.PEDESTRIAN
        turned = np.abs(wrap(error[:, 2])) <= np.deg2rad(self._config.located_heading_deg)
        near = np.hypot(error[:, 0], error[:, 1]) <= self._config.located_position_m
        located[on] = near & (turned | is_person)
        return located


def _actor_rows(frame_truth: FrameTruth, matches: TrackMatches, tracks: Tracks, iou_min: float) -> Ints:
    """(T,) row of the actor that each track is on, `NO_ROW` for none."""
    row = matches.actor_row.copy()
    live = (tracks.status == Status.TENTATIVE) | (tracks.status == Status.CONFIRMED)
    open_tracks = np.flatnonzero(live & (row == NO_ROW))
    if not len(frame_truth.actors) or not len(open_tracks):
        return row
    boxes = matches.boxes_ego[open_tracks]
    overlap = frame_truth.overlap(boxes)
    by_overlap = np.where(overlap.max(axis=0) >= iou_min, overlap.argmax(axis=0), NO_ROW)
    row[open_tracks] = np.where(by_overlap == NO_ROW, _nearest_inside(frame_truth.boxes_ego, boxes), by_overlap)
    return row


def _nearest_inside(actors: Floats, boxes: Floats) -> Ints:
    """(T,) row of the actor (A, 5) whose centre is inside a box (T, 5) and nearest to its centre, `NO_ROW` for none."""
    offset = np.abs(turned(actors[:, :2] - boxes[:, None, :2], -boxes[:, None, 2]))  # (T, A, 2)
    inside: Bools = np.asarray((offset <= 0.5 * boxes[:, None, 3:]).all(axis=2))
    nearest = np.where(inside, np.hypot(offset[..., 0], offset[..., 1]), np.inf).argmin(axis=1)
    return np.where(inside.any(axis=1), nearest, NO_ROW)


COLUMNS = (
    "actor_id", "name", "kind", "stage", "reached", "frame", "time_s",
    "delay_s", "range_m", "ttc_s", "meeting_m", "meeting_s",
)  # fmt: skip

BOX = ("x_world_m", "y_world_m", "yaw_world_rad", "length_m", "width_m")
VELOCITY = ("vx_world_mps", "vy_world_mps")


def emergence_table(first: Mapping[str, Mapping[int, int]], truth: pd.DataFrame, ego: pd.DataFrame) -> pd.DataFrame:
    """Return the table `emergence` of a run.

    Parameters
    ----------
    first
        First frame of each stage by actor id, see `EmergenceLog.first`.
    truth, ego
        Tables of the run.

    Returns
    -------
    DataFrame
        `COLUMNS`, a row per actor and stage. A stage that is not `reached` has the values of the last frame with the
        actor: it is censored there. `delay_s` is NaN for an actor without any beam, the time to collision infinite
        without a collision course, `meeting_m` and `meeting_s` NaN without a meeting point and negative beyond it.
    """
    boxes, velocities, time_s = _columns(truth, BOX), _columns(truth, VELOCITY), truth["time_s"].to_numpy()
    is_traffic = (truth["kind"] != Kind.OBSTACLE.name.lower()).to_numpy()
    if not len(ego) or not is_traffic.any():
        return _table(truth, np.empty(0, np.int64), *np.empty((5, 0)))
    path = EgoPath.of(ego["time_s"].to_numpy(), _columns(ego, BOX))
    moments, meetings = [], []
    for actor, rows in rows_by_actor(truth["actor_id"].to_numpy(), np.flatnonzero(is_traffic)):
        moments.append(_moments(first, actor, truth["frame"].to_numpy(), rows))
        meetings.append(path.meeting(boxes[rows], float(np.hypot(*velocities[rows[-1]]))))
    at, reached = (np.array(part) for part in zip(*moments, strict=True))
    first_beam_s = np.where(reached[:, BEAM], time_s[at[:, BEAM]], np.nan)
    delay_s = (time_s[at] - first_beam_s[:, None]).ravel()
    meeting_s, along_m = np.repeat(meetings, len(STAGES), axis=0).T
    at = at.ravel()
    now = np.searchsorted(ego["frame"].to_numpy(), truth["frame"].to_numpy()[at])
    ttc_s = time_to_collision(_columns(ego, BOX)[now], _columns(ego, VELOCITY)[now], boxes[at], velocities[at])
    to_meeting = along_m - path.along_m[now], meeting_s - time_s[at]
    return _table(truth, at, reached.ravel(), delay_s, ttc_s, *to_meeting)


BEAM = [*STAGES].index("first_beam")


def _moments(first: Mapping[str, Mapping[int, int]], actor: int, frame: Ints, rows: Ints) -> tuple[Ints, Bools]:
    """Return the row of `truth` of an actor at each stage, and which of the stages it has reached."""
    reached = np.array([first[stage].get(actor, -1) for stage in STAGES])
    at = rows[np.minimum(np.searchsorted(frame[rows], reached), len(rows) - 1)]
    return np.where(reached >= 0, at, rows[-1]), reached >= 0


def _table(
    truth: pd.DataFrame, at: Ints, reached: Bools, delay_s: Floats, ttc_s: Floats, meeting_m: Floats, meeting_s: Floats
) -> pd.DataFrame:
    """Return the table from the rows of `truth` of its moments `at` (n,)."""
    stages = np.tile(np.arange(len(STAGES), dtype=np.int8), len(at) // len(STAGES))
    columns = {
        **{name: truth[name].array.take(at) for name in COLUMNS if name in truth},
        "stage": pd.Categorical.from_codes(stages, list(STAGES)), "reached": reached.astype(np.bool_),
        "delay_s": delay_s, "ttc_s": ttc_s, "meeting_m": meeting_m, "meeting_s": meeting_s,
    }  # fmt: skip
    return pd.DataFrame({name: columns[name] for name in COLUMNS}, copy=False)


def _columns(rows: pd.DataFrame, names: tuple[str, ...]) -> Floats:
    return np.column_stack([rows[name].to_numpy(np.float64) for name in names])


Row = Mapping[str, Any]
"""Row of the table `emergence`, by column."""
NO_TARGET = "the scenario names no grading.target"
NEVER = "never reached"
NEVER_FOR_HALF = "half of the actors or more never reached it"


def grade_emergence(sheet: MetricSheet, emergence: pd.DataFrame, target: str) -> None:
    """Enter the `emergence` metrics.

    Parameters
    ----------
    emergence
        Table of the run.
    target
        Name of the target; empty for none.
    """
    of_target = emergence[emergence["name"] == target].to_dict("records") if target else []
    rows = {row["stage"]: row for row in of_target}
    why = "" if rows else f'no actor is named "{target}"' if target else NO_TARGET
    for stage in STAGES:
        _write_stage(sheet, stage, rows.get(stage), why)
    _write_end(sheet, [row for row in of_target if not row["reached"]], why)
    columns = {name: np.asarray(emergence[name]) for name in ("kind", "stage", "delay_s", "range_m", "reached")}
    seen = ~np.isnan(columns["delay_s"].astype(np.float64))
    for group, kinds in list(EMERGING.items())[1:]:
        rows_of_group = np.flatnonzero(seen & np.isin(columns["kind"].astype(np.str_), kinds))
        found = {name: column[rows_of_group] for name, column in columns.items()}
        _write_group(sheet, group, found)


def _write_stage(sheet: MetricSheet, stage: str, row: Row | None, why: str) -> None:
    """Enter all measures of the target at one stage; `row` is its row of the table."""
    reached = row is not None and bool(row["reached"])
    for name in [*MEASURES][:-1]:
        value = _number(row, name) if row is not None and reached else None
        sheet.write(_name(name, stage), value, int(value is not None), why or _why_none(name, reached))
    sheet.write(_name("reached", stage), None if row is None else float(reached), int(row is not None), why)


def _name(measure: str, stage: str, group: str = "") -> str:
    """Return the name of a measure of the target, or of a group."""
    return f"emergence.{measure}{{stage={stage}{f',group={group}' if group else ''}}}"


def _write_end(sheet: MetricSheet, missed: list[Row], why: str) -> None:
    """Enter the target's end of observation, that of a stage of `missed`; if all stages are reached, there is none."""
    for name in SURVIVAL:
        value = _number(missed[0], name) if missed else None
        reason = why or ("all stages are reached" if not missed else _why_none(name, True))
        sheet.write(_name(name, END), value, int(value is not None), reason)


def _number(row: Row, name: str) -> float | None:
    """Return a measure of a row, None if it does not exist."""
    value = float(row[name])
    return value if np.isfinite(value) else None


def _why_none(name: str, reached: bool) -> str:
    if not reached:
        return NEVER
    if name == "ttc_s":
        return "no collision course at constant velocities"
    return "the paths do not meet in the run" if name.startswith("meeting") else "no beam ever ended on it"


def _write_group(sheet: MetricSheet, group: str, columns: Mapping[str, npt.NDArray[Any]]) -> None:
    """Enter the medians and shares of all actors of a group that any beam ended on.

    `columns` (n,) are those of the actors' rows of the table.
    """
    for stage in STAGES:
        found = np.flatnonzero(columns["stage"] == stage)
        none, reached = f"no beam ended on a {group}", columns["reached"][found].astype(np.bool_)
        delay = median(columns["delay_s"][found].astype(np.float64), reached)
        near = np.where(reached, columns["range_m"][found].astype(np.float64), -np.inf)
        range_m = float(np.quantile(near, 0.5, method="inverted_cdf")) if len(near) else -np.inf
        for name, value in (("delay_s", delay), ("range_m", range_m)):
            known = value if np.isfinite(value) else None
            sheet.write(_name(name, stage, group), known, len(found), NEVER_FOR_HALF if len(found) else none)
        sheet.mean(_name("reached", stage, group), reached, none)
    sheet.write(_name("delay_s", END, group), None, 0, "only the target has an end of observation")

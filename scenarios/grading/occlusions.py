"""Occlusions of graded vehicles: who hides them, gaps in tracks, and what the tracks did meanwhile."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.grading.frame_tables import rows_by_actor
from luxloop.scenarios.grading.frame_truth import IS_ON_NOTHING, IS_VEHICLE, FrameTruth
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.matching import NO_TRACK
from luxloop.scenarios.grading.plane_geometry import wrap
from luxloop.sensor_model.truth import NO_ACTOR, Part
from luxloop.sim.world import Kind

CORNERS = np.array([[0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]])
"""(4, 2) corners of a box, in units of its length and width."""


class BlockerLog:
    """Finds the blockers of hidden vehicles that were graded before; one log per run.

    Parameters
    ----------
    hidden_fraction_max
        A vehicle with at most this visible fraction is hidden, see `GradingConfig`.
    """

    def __init__(self, hidden_fraction_max: float) -> None:
        self._limit = hidden_fraction_max
        self._known: set[int] = set()

    def rows(self, frame_truth: FrameTruth) -> dict[str, npt.NDArray[Any]]:
        """Return the rows of the table `blockers` of one frame."""
        ids, truth = frame_truth.actors.id, frame_truth.truth
        self._known.update(ids[frame_truth.graded].tolist())
        hidden = (truth.visible_fraction <= self._limit) & (truth.hits_alone > 0) & IS_VEHICLE[frame_truth.actors.kind]
        rows = [row for row in np.flatnonzero(hidden).tolist() if int(ids[row]) in self._known]
        views = unit_views(frame_truth) if rows else []
        found = [(int(ids[row]), *pair) for row in rows for pair in blockers(frame_truth, views, row)]
        actor, blocker, points = np.array(found, dtype=np.int64).reshape(-1, 3).T
        return {"actor_id": actor, "blocker_id": blocker, "points": points}


class UnitView(NamedTuple):
    """P points on actors and static obstacles, as one LIDAR sees them."""

    origin: Floats
    """(2,) position of the LIDAR, ego frame [m]."""
    row: Ints
    """(P,) row of the actor, -1 for static obstacles."""
    range_m: Floats
    """(P,) distance from the LIDAR [m]."""
    bearing: Floats
    """(P,) bearing from the LIDAR, ego frame [rad]."""

    def in_front(self, box: Floats) -> Ints:
        """Return the rows of the points between the LIDAR and a box (5,) in the ego frame."""
        x, y, yaw, length, width = box
        cos, sin = np.cos(yaw), np.sin(yaw)
        corners = (CORNERS * (length, width)) @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
        middle = _bearing(box[:2] - self.origin)
        offsets = wrap(_bearing(corners - self.origin) - middle)
        nearer = np.flatnonzero(self.range_m < np.hypot(*(box[:2] - self.origin)))
        offset = wrap(self.bearing[nearer] - middle)
        rows: Ints = self.row[nearer[(offsets.min() <= offset) & (offset <= offsets.max())]]
        return rows


def unit_views(frame_truth: FrameTruth) -> list[UnitView]:
    """Return the view of each LIDAR."""
    truth, scan = frame_truth.truth, frame_truth.scan
    is_static = (truth.actor_id == NO_ACTOR) & (truth.part == Part.OBSTACLE)
    solid = (is_static | (frame_truth.point_row >= 0)) & ~IS_ON_NOTHING[truth.cause]
    views = []
    for unit in range(truth.unit_hits_alone.shape[1]):
        own = np.flatnonzero(solid & (scan.unit == unit))
        origin = np.zeros(2) if scan.unit_positions_ego is None else scan.unit_positions_ego[unit]
        ray = scan.points_ego.take(own, axis=0)[:, :2].astype(np.float64) - origin
        views.append(UnitView(origin, frame_truth.point_row[own], np.hypot(*ray.T), _bearing(ray)))
    return views


def blockers(frame_truth: FrameTruth, views: list[UnitView], row: int) -> Iterator[tuple[int, int]]:
    """Yield each blocker of the actor in a row with its number of points, in ascending order of ids.

    A blocker is an actor, or `NO_ACTOR` for static obstacles, with points in the angle under which a LIDAR would see
    the actor's box, and nearer than the centre of the box. Beams are evenly spaced in angle, so the number of points
    measures the covered part of this angle.
    """
    actors, points = frame_truth.actors.id, np.zeros(len(frame_truth.actors) + 1, dtype=np.int64)
    for unit in np.flatnonzero(frame_truth.truth.unit_hits_alone[row]).tolist():
        points += np.bincount(views[unit].in_front(frame_truth.boxes_ego[row]) + 1, minlength=len(points))
    points[row + 1] = 0
    for blocker in np.flatnonzero(points).tolist():
        yield NO_ACTOR if blocker == 0 else int(actors[blocker - 1]), int(points[blocker])


def _bearing(ray: Floats) -> Floats:
    """Return the bearings (...) of rays (..., 2) [rad]."""
    bearing: Floats = np.arctan2(ray[..., 1], ray[..., 0])
    return bearing


MANOEUVRES = ("keeps", "brakes", "accelerates", "turns", "changes lane")

TURN_DEG = 15.0
"""A vehicle whose heading changes by at least this angle turns: a lane change returns to its heading."""
STRAIGHT_DEG = 5.0
"""A vehicle that is `LANE_M` to the side with a smaller change of heading has changed its lane."""
LANE_M = 1.0
"""About a third of a lane."""
SPEEDING_MPS2 = 0.5
"""Least mean change of speed of a vehicle that brakes or accelerates; drivers vary their speed by less."""


USED = (
    *("actor_id", "name", "kind", "frame", "time_s", "graded", "track_id", "visible_fraction", "hits_alone", "range_m"),
    *("x_world_m", "y_world_m", "yaw_world_rad", "vx_world_mps", "vy_world_mps", "changes_lane"),
)
"""Columns of `truth` that describe an occlusion."""
Rows = Mapping[str, npt.NDArray[Any]]
"""Columns `USED` of one vehicle in time order."""


def manoeuvre(rows: Rows) -> str:
    """Return the manoeuvre, one of `MANOEUVRES`, between the first and the last of a vehicle's rows of `truth`.

    A turn counts before a lane change, and both before a change of speed.
    """
    x, y, yaw, time_s = (rows[name][[0, -1]] for name in ("x_world_m", "y_world_m", "yaw_world_rad", "time_s"))
    turned_deg = abs(float(np.degrees(wrap(np.diff(yaw))[0])))
    aside_m = abs(float(-np.sin(yaw[0]) * (x[1] - x[0]) + np.cos(yaw[0]) * (y[1] - y[0])))
    if turned_deg >= TURN_DEG:
        return "turns"
    if rows["changes_lane"].any() or (aside_m >= LANE_M and turned_deg < STRAIGHT_DEG):
        return "changes lane"
    duration_s = float(time_s[1] - time_s[0])
    speed = np.hypot(rows["vx_world_mps"][[0, -1]], rows["vy_world_mps"][[0, -1]])
    change_mps2 = (speed[1] - speed[0]) / duration_s if duration_s > 0 else 0.0
    if abs(change_mps2) >= SPEEDING_MPS2:
        return "brakes" if change_mps2 < 0 else "accelerates"
    return "keeps"


class Gap(NamedTuple):
    """An occlusion, as rows of one vehicle's part of the table `truth` in time order."""

    last: int
    """Last graded row before the gap."""
    again: int
    """First graded row after it."""
    before: int
    """Last graded row with a track up to `last`."""
    after: int | None
    """First graded row with a track from `again` on; None if there is none in time."""


def gaps(vehicle: Rows, config: GradingConfig) -> Iterator[Gap]:
    """Yield each occlusion of one vehicle.

    An occlusion is a gap of at most `LONGEST_S`, or `memory_s` if that is longer, in the vehicle's grading, with a
    visible fraction of at most `hidden_fraction_max`, in which the vehicle would have returns without occluders. The
    track before is the last one that followed the graded vehicle, the track after is the first one; both are at most
    `memory_s` from the gap. A gap without a track before is left out.
    """
    graded, time = vehicle["graded"], vehicle["time_s"]
    hidden = (vehicle["visible_fraction"] <= config.hidden_fraction_max) & (vehicle["hits_alone"] > 0)
    followed = np.flatnonzero(graded & (vehicle["track_id"] != NO_TRACK))
    seen = np.flatnonzero(graded)
    longest_s = max(LONGEST_S, config.memory_s)
    for last, again in zip(*(seen[i].tolist() for i in _apart(seen)), strict=True):
        if time[again] - time[last] > longest_s or not hidden[last + 1 : again].any():
            continue
        before, after = followed[followed <= last], followed[followed >= again]
        if not len(before) or time[last] - time[before[-1]] > config.memory_s:
            continue
        in_time = len(after) and time[after[0]] - time[again] <= config.memory_s
        yield Gap(last, again, int(before[-1]), int(after[0]) if in_time else None)


def _apart(rows: Ints) -> tuple[Ints, Ints]:
    """Return the places in ascending rows (n,) before and after each missing row."""
    before = np.flatnonzero(np.diff(rows) > 1)
    return before, before + 1


COLUMNS = (
    *("actor_id", "name", "kind", "hidden_by_id", "hidden_by", "hidden_by_kind", "hidden_by_share"),
    *("frame", "time_s", "end_frame", "gap_s", "hidden_s", "visible_before", "visible_min", "range_m", "speed_mps"),
    *("manoeuvre", "track_id", "survived", "track_id_after", "reacquired_s", "position_error_m", "heading_error_deg"),
)
STATIC = "static obstacle"
"""Blocker that is not an actor."""
LONGEST_S = 10.0
"""A vehicle that comes back after a longer time is taken as a new one."""
BEFORE_S = 1.0
"""Interval before the gap whose largest visible fraction counts: in the last frame the vehicle is nearly hidden."""
KINDS = pd.CategoricalDtype([kind.name.lower() for kind in Kind])
TYPES = {
    **dict.fromkeys(("actor_id", "hidden_by_id", "frame", "end_frame", "track_id", "track_id_after"), np.int64),
    **dict.fromkeys(("name", "hidden_by"), np.dtype("O")),
    **dict.fromkeys(("kind", "hidden_by_kind"), KINDS),
    "survived": np.bool_,
    "manoeuvre": pd.CategoricalDtype(list(MANOEUVRES)),
}
"""Types of the columns that are no numbers of type float64."""


def occlusion_table(
    truth: pd.DataFrame, tracks: pd.DataFrame, config: GradingConfig, blockers: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Return the table `occlusions` of a run.

    Parameters
    ----------
    truth, tracks, blockers
        Tables of the run. Without blockers, those of the occlusions are not named.
    config
        Limits of grading. Gaps longer than `memory_s` are in the table, too, but not in the metrics.

    Returns
    -------
    DataFrame
        `COLUMNS`, in the order of the vehicles' ids. Ids are -1, texts empty and numbers NaN where there is none.
    """
    vehicles = dict(_vehicles(truth))
    names = {actor_id: (vehicle["name"][0], vehicle["kind"][0]) for actor_id, vehicle in vehicles.items()}
    rows = []
    for vehicle in vehicles.values():
        for gap in gaps(vehicle, config):
            row = _row(vehicle, gap, config.hidden_fraction_max) | _after(vehicle, gap, tracks)
            rows.append(row | _hidden_by(_hiding(blockers, row), names))
    return _typed(rows)


def _vehicles(truth: pd.DataFrame) -> Iterator[tuple[int, Rows]]:
    """Yield the id and the rows of each actor."""
    columns = {name: np.asarray(truth[name]) for name in USED}
    in_time = np.argsort(columns["frame"], kind="stable")
    for actor_id, rows in rows_by_actor(columns["actor_id"], in_time):
        yield actor_id, {name: values[rows] for name, values in columns.items()}


def _row(vehicle: Rows, gap: Gap, hidden_fraction_max: float) -> dict[str, Any]:
    """Return the columns of one gap that need only the vehicle's own rows up to its end."""
    last, again, before, _ = gap
    time, visible = vehicle["time_s"], vehicle["visible_fraction"]
    seen = (time >= time[last] - BEFORE_S) & (time <= time[last])
    within = {name: values[last : again + 1] for name, values in vehicle.items()}
    dark = within["visible_fraction"][:-1] <= hidden_fraction_max
    return {
        **{name: vehicle[name][last] for name in ("actor_id", "name", "kind", "frame", "time_s", "range_m")},
        "end_frame": vehicle["frame"][again],
        "gap_s": time[again] - time[last],
        "hidden_s": float(np.diff(within["time_s"])[dark].sum()),  # each frame counts until the next
        "visible_before": np.fmax.reduce(visible[seen]),
        "visible_min": np.fmin.reduce(visible[last + 1 : again]),
        "speed_mps": np.hypot(vehicle["vx_world_mps"][last], vehicle["vy_world_mps"][last]),
        "manoeuvre": manoeuvre(within),
        "track_id": vehicle["track_id"][before],
    }


def _after(vehicle: Rows, gap: Gap, tracks: pd.DataFrame) -> dict[str, Any]:
    """Return the columns of one gap that are about the track after it; without one, the id did not survive."""
    if gap.after is None:
        return {"survived": False, "track_id_after": NO_TRACK}
    track_id, frame = vehicle["track_id"][gap.after], vehicle["frame"][gap.after]
    track = tracks[(tracks["frame"].to_numpy() == frame) & (tracks["track_id"].to_numpy() == track_id)].iloc[0]
    apart = (track[f"{axis}_world_m"] - vehicle[f"{axis}_world_m"][gap.after] for axis in "xy")
    return {
        "survived": track_id == vehicle["track_id"][gap.before],
        "track_id_after": track_id,
        "reacquired_s": vehicle["time_s"][gap.after] - vehicle["time_s"][gap.again],
        "position_error_m": np.hypot(*apart),
        "heading_error_deg": track["heading_error_deg"],
    }


def _hiding(blockers: pd.DataFrame | None, row: Rows) -> pd.Series:
    """Return the points of each blocker of an occlusion by its id."""
    if blockers is None:
        return pd.Series(dtype=np.int64)
    frame = blockers["frame"]
    within = (blockers["actor_id"] == row["actor_id"]) & frame.between(row["frame"], row["end_frame"])
    return blockers[within].groupby("blocker_id")["points"].sum()


def _hidden_by(points: pd.Series, names: Mapping[int, tuple[str, str]]) -> dict[str, Any]:
    """Return the blocker with most points in the frames of a gap, and its share of the points of all blockers."""
    if points.empty:  # e.g. all units that would see the vehicle are silent
        return {"hidden_by_id": NO_ACTOR, "hidden_by": ""}
    first = int(points.idxmax())
    name, kind = (STATIC, Kind.OBSTACLE.name.lower()) if first == NO_ACTOR else names[first]
    share = points[first] / points.sum()
    return {"hidden_by_id": first, "hidden_by": name, "hidden_by_kind": kind, "hidden_by_share": share}


def _typed(rows: list[dict[str, Any]]) -> pd.DataFrame:
    """Return the table of its rows, with the same types without rows; values that are left out are NaN."""
    columns = {name: [row.get(name, np.nan) for row in rows] for name in COLUMNS}
    return pd.DataFrame({name: _column(values, TYPES.get(name, np.float64)) for name, values in columns.items()})


def _column(values: list[Any], kind: Any) -> Any:
    """Return the values of a column; texts as a series, which keeps their type."""
    if isinstance(kind, pd.CategoricalDtype):
        return pd.Categorical(values, dtype=kind)
    return pd.Series(values, dtype=kind) if kind == np.dtype("O") else np.array(values, dtype=kind)

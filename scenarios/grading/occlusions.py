"""Occlusions of graded vehicles: their table, gaps in tracks, and what the tracks did meanwhile."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.matching import NO_TRACK
from luxloop.scenarios.grading.plane_geometry import wrap
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import Kind

MANOEUVRES = ("keeps", "brakes", "accelerates", "turns", "changes lane")

TURN_DEG = 15.0
"""A vehicle whose heading changes by at least this angle turns: a lane change returns to its heading."""
STRAIGHT_DEG = 5.0
"""A vehicle that is `LANE_M` to the side with a smaller change of heading has changed its lane."""
LANE_M = 1.0
"""About a third of a lane."""
SPEEDING_MPS2 = 0.5
"""Least mean change of speed of a vehicle that brakes or accelerates; drivers vary their speed by less."""


def manoeuvre(rows: pd.DataFrame) -> str:
    """Return the manoeuvre, one of `MANOEUVRES`, between the first and the last of a vehicle's rows of `truth`.

    A turn counts before a lane change, and both before a change of speed.
    """
    first, last = rows.iloc[0], rows.iloc[-1]
    yaw = float(first["yaw_world_rad"])
    turned_deg = abs(float(np.degrees(wrap(np.array([last["yaw_world_rad"] - yaw]))[0])))
    x, y = last["x_world_m"] - first["x_world_m"], last["y_world_m"] - first["y_world_m"]
    aside_m = abs(-np.sin(yaw) * x + np.cos(yaw) * y)
    if turned_deg >= TURN_DEG:
        return "turns"
    if rows["changes_lane"].any() or (aside_m >= LANE_M and turned_deg < STRAIGHT_DEG):
        return "changes lane"
    duration_s = float(last["time_s"] - first["time_s"])
    speed = np.hypot(rows["vx_world_mps"].to_numpy(), rows["vy_world_mps"].to_numpy())
    change_mps2 = (speed[-1] - speed[0]) / duration_s if duration_s > 0 else 0.0
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


def gaps(vehicle: pd.DataFrame, config: GradingConfig, longest_s: float) -> Iterator[Gap]:
    """Yield each occlusion of one vehicle, from its rows of `truth` in time order.

    An occlusion is a gap of at most `longest_s` in the vehicle's grading, with a visible fraction of at most
    `hidden_fraction_max`, in which the vehicle would have returns without occluders. The track before is the last one
    that followed the graded vehicle, the track after is the first one; both are at most `memory_s` from the gap. A gap
    without a track before is left out.
    """
    graded = vehicle["graded"].to_numpy()
    time = vehicle["time_s"].to_numpy()
    followed = np.flatnonzero(graded & (vehicle["track_id"].to_numpy() != NO_TRACK))
    dark = (vehicle["visible_fraction"] <= config.hidden_fraction_max) & (vehicle["hits_alone"] > 0)
    hidden = dark.to_numpy()
    for last, again in pairwise(np.flatnonzero(graded).tolist()):
        if time[again] - time[last] > longest_s or not hidden[last + 1 : again].any():
            continue
        before, after = followed[followed <= last], followed[followed >= again]
        if not len(before) or time[last] - time[before[-1]] > config.memory_s:
            continue
        in_time = len(after) and time[after[0]] - time[again] <= config.memory_s
        yield Gap(last, again, int(before[-1]), int(after[0]) if in_time else None)


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
TYPES = {
    **dict.fromkeys(("actor_id", "hidden_by_id", "frame", "end_frame", "track_id", "track_id_after"), np.int64),
    **dict.fromkeys(("name", "hidden_by"), np.dtype("O")),
    **dict.fromkeys(("survived",), np.bool_),
}
"""Types of the columns that are neither numbers of type float64 nor categories."""


def occlusion_table(
    truth: pd.DataFrame, tracks: pd.DataFrame, blockers: pd.DataFrame, config: GradingConfig
) -> pd.DataFrame:
    """Return the table `occlusions` of a run.

    Parameters
    ----------
    truth, tracks, blockers
        Tables of the run.
    config
        Limits of grading. Gaps longer than `memory_s` are in the table, too, but not in the metrics.

    Returns
    -------
    DataFrame
        `COLUMNS`, in the order of the vehicles' ids. Ids are -1, texts empty and numbers NaN where there is none.
    """
    columns = ["frame", "track_id", "x_world_m", "y_world_m", "heading_error_deg"]
    tracked = truth.merge(tracks[columns], how="left", on=["frame", "track_id"], suffixes=("", "_track"))
    names = truth.drop_duplicates("actor_id").set_index("actor_id")[["name", "kind"]]
    rows = []
    for actor_id, vehicle in tracked.sort_values("frame", kind="stable").groupby("actor_id"):
        for gap in gaps(vehicle, config, LONGEST_S):
            row = _row(vehicle, gap, config.hidden_fraction_max)
            hiding = blockers[blockers["actor_id"] == actor_id]
            within = hiding["frame"].between(row["frame"], row["end_frame"])
            rows.append(row | _hidden_by(hiding[within], names))
    return _typed(pd.DataFrame(rows, columns=list(COLUMNS)))


def _row(vehicle: pd.DataFrame, gap: Gap, hidden_fraction_max: float) -> dict[str, Any]:
    """Return the columns of one gap that need only the vehicle's own rows."""
    last, again, before = (vehicle.iloc[i] for i in gap[:3])
    hidden = vehicle.iloc[gap.last + 1 : gap.again]
    seen = vehicle[vehicle["time_s"].between(last["time_s"] - BEFORE_S, last["time_s"])]
    row = {
        "actor_id": last["actor_id"],
        "name": last["name"],
        "kind": last["kind"],
        "frame": last["frame"],
        "time_s": last["time_s"],
        "end_frame": again["frame"],
        "gap_s": again["time_s"] - last["time_s"],
        "hidden_s": _hidden_s(vehicle.iloc[gap.last : gap.again + 1], hidden_fraction_max),
        "visible_before": seen["visible_fraction"].max(),
        "visible_min": hidden["visible_fraction"].min(),
        "range_m": last["range_m"],
        "speed_mps": np.hypot(last["vx_world_mps"], last["vy_world_mps"]),
        "manoeuvre": manoeuvre(vehicle.iloc[gap.last : gap.again + 1]),
        "track_id": before["track_id"],
        "survived": False,
        "track_id_after": NO_TRACK,
        "reacquired_s": np.nan,
        "position_error_m": np.nan,
        "heading_error_deg": np.nan,
    }
    if gap.after is None:
        return row
    after = vehicle.iloc[gap.after]
    return row | {
        "survived": after["track_id"] == before["track_id"],
        "track_id_after": after["track_id"],
        "reacquired_s": after["time_s"] - again["time_s"],
        "position_error_m": np.hypot(*(after[f"{axis}_world_m_track"] - after[f"{axis}_world_m"] for axis in "xy")),
        "heading_error_deg": after["heading_error_deg"],
    }


def _hidden_s(rows: pd.DataFrame, hidden_fraction_max: float) -> float:
    """Return the time [s] for which the vehicle is hidden, each frame counting until the next."""
    step = np.diff(rows["time_s"].to_numpy())
    return float(step[(rows["visible_fraction"] <= hidden_fraction_max).to_numpy()[:-1]].sum())


def _hidden_by(hiding: pd.DataFrame, names: pd.DataFrame) -> dict[str, Any]:
    """Return the blocker with most points in the frames of a gap, and its share of the points of all blockers."""
    points = hiding.groupby("blocker_id")["points"].sum()
    if points.empty:  # e.g. all units that would see the vehicle are silent
        return {"hidden_by_id": NO_ACTOR, "hidden_by": "", "hidden_by_kind": np.nan, "hidden_by_share": np.nan}
    first = int(points.idxmax())
    static = first == NO_ACTOR
    return {
        "hidden_by_id": first,
        "hidden_by": STATIC if static else names.at[first, "name"],
        "hidden_by_kind": Kind.OBSTACLE.name.lower() if static else names.at[first, "kind"],
        "hidden_by_share": points[first] / points.sum(),
    }


def _typed(table: pd.DataFrame) -> pd.DataFrame:
    """Return the table with its types, which a table without rows has, too."""
    kinds = [kind.name.lower() for kind in Kind]
    categories = {"kind": kinds, "hidden_by_kind": kinds, "manoeuvre": list(MANOEUVRES)}
    for name in COLUMNS:
        if name in categories:
            table[name] = pd.Categorical(table[name], categories[name])
        else:
            table[name] = table[name].astype(TYPES.get(name, np.float64))
    return table


class Occlusion(NamedTuple):
    """Occlusion of a followed vehicle."""

    time_s: float
    """Time of the last graded frame before the occlusion [s]."""
    gap_s: float
    """Time from the last graded frame before to the first after the occlusion [s]."""
    survived: bool
    """True if the same track follows the vehicle before and after."""
    reacquired_s: float
    """Time from the end of the gap until a track follows the vehicle [s]; NaN if none does in time."""
    error_m: float
    """Distance of that track's centre from the vehicle's in that frame [m]; NaN if there is no such track."""


def occlusions_of(truth: pd.DataFrame, tracks: pd.DataFrame, config: GradingConfig) -> Iterator[tuple[int, Occlusion]]:
    """Yield every occlusion with the id of its actor, from the tables `truth` and `tracks` of a run."""
    place = ["frame", "track_id", "x_world_m", "y_world_m"]
    columns = [*place, "actor_id", "time_s", "graded", "visible_fraction", "hits_alone"]
    tracked = truth[columns].merge(tracks[place], how="left", on=["frame", "track_id"], suffixes=("", "_track"))
    for actor_id, vehicle in tracked.sort_values("frame", kind="stable").groupby("actor_id"):
        for occlusion in _of_vehicle(vehicle, config):
            yield int(actor_id), occlusion


def _of_vehicle(vehicle: pd.DataFrame, config: GradingConfig) -> Iterator[Occlusion]:
    """Yield each occlusion of at most `memory_s` of one vehicle, from its rows of `truth` joined with its tracks.

    Without a track after the gap, the id did not survive.
    """
    track, time = vehicle["track_id"].to_numpy(), vehicle["time_s"].to_numpy()
    error = np.hypot(*(vehicle[f"{axis}_world_m_track"] - vehicle[f"{axis}_world_m"] for axis in "xy")).to_numpy()
    for last, again, before, after in gaps(vehicle, config, config.memory_s):
        start, gap_s = float(time[last]), float(time[again] - time[last])
        if after is None:
            yield Occlusion(start, gap_s, False, np.nan, np.nan)
        else:
            same = bool(track[after] == track[before])
            yield Occlusion(start, gap_s, same, float(time[after] - time[again]), float(error[after]))

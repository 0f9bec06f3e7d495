"""Table of occlusions: a row per gap in which a followed vehicle is hidden, with its blocker and what followed."""

from typing import Any

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.manoeuvre import MANOEUVRES, manoeuvre
from luxloop.scenarios.grading.matching import NO_TRACK
from luxloop.scenarios.grading.occlusion_gaps import Gap, gaps
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import Kind

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

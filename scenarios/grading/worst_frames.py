"""Frames in which a metric is worst, as starting points of an analysis.

A metric is worst at the observations with the largest error by its own definition: the value of a metric that should be
less, the distance from the best value of one that should be more. A share ranks the observations that count against it
by `MetricDefinition.ranked_by`.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.grading.figures import counted
from luxloop.scenarios.grading.observations import Observations, RunObservations
from luxloop.scenarios.grading.snapshots import CONFIRMATION_S, listed
from luxloop.scenarios.metrics.definition import Selection
from luxloop.scenarios.metrics.definitions import DRIVERS, SHARE, find_metric
from luxloop.scenarios.metrics.own_metric import PREFIX
from luxloop.scenarios.result import Result
from luxloop.sensor_model.truth import NO_ACTOR

Row = Mapping[str, Any]
"""A row of a table by column."""

IDENTITIES = ("id_switch", "fragments", "survival")
"""Parts of the names of metrics about identities; they are worst where a vehicle goes from one track to another."""
OF_TRACKS = ("score", "gospa", "occlusion")
"""Kinds of metrics about tracks without an error per observation."""
NEW_VEHICLE_WEIGHT = 0.01
"""Weight of a vehicle without a hit that was first graded less than `CONFIRMATION_S` ago."""
UNITS = {"deg": " deg", "m": " m", "s": " s", "mps": " m/s", "mps2": " m/s^2"}
"""Units by the last word of a column's name."""


class WorstFrame(NamedTuple):
    """A frame to look at, and a description of the error in it."""

    frame: int
    time_s: float
    what: str
    actor_id: int = NO_ACTOR
    """The vehicle with the error; `NO_ACTOR` if the error is not that of one vehicle."""

    def __str__(self) -> str:
        return f"frame {self.frame} ({self.time_s:.2f} s): {self.what}"


class RankedRows(NamedTuple):
    """Rows with `frame` and `time_s`, and the error of each."""

    rows: pd.DataFrame
    error: Floats
    """(n,) the larger, the worse; 0 and NaN mean no error."""
    describe: Callable[[Row], str]


def worst_frames(result: Result, metric: str, count: int = 3) -> list[WorstFrame]:
    """Return up to `count` frames in which a metric is worst, the worst first.

    The list is empty for a metric without a value, for own metrics, and for metrics without a value per frame, such as
    `dataset.*` and `perf.*`.
    """
    known = result.metrics.get(metric)
    if known is None or known.value is None or metric.startswith(PREFIX):
        return []
    return worst_of_run(result.metrics.run, find_metric(metric), count)


def worst_of_run(run: RunObservations, selection: Selection, count: int) -> list[WorstFrame]:
    """Return up to `count` frames in which a metric with its filters is worst, the worst first."""
    ranked = _ranked(selection, run)
    if ranked is None:
        return []
    rows = ranked.rows.assign(error=np.nan_to_num(ranked.error, nan=0.0, posinf=np.inf))
    bad = rows[rows["error"] > 0].sort_values(["error", "frame"], ascending=[False, True], kind="stable")
    return [
        WorstFrame(row["frame"], row["time_s"], ranked.describe(row), row.get("actor_id", NO_ACTOR))
        for row in bad.drop_duplicates("frame").head(count).to_dict("records")
    ]


def vehicle_names(truth: pd.DataFrame) -> dict[int, str]:
    """Return the names of the actors by id, from the truth table: the only names of vehicles that users see."""
    first = truth.drop_duplicates("actor_id")
    return {int(actor): str(name) for actor, name in zip(first["actor_id"], first["name"], strict=True)}


def _ranked(selection: Selection, run: RunObservations) -> RankedRows | None:
    """Return the rows behind a metric with their errors, None for metrics without rows of single frames."""
    kind, name = selection.definition.kind, selection.definition.name
    if kind in OF_TRACKS:
        changes = any(part in name for part in IDENTITIES)
        return _changes_of_track(run.truth) if changes else _misses(run)
    if kind == "control":
        return _of_drive(run.tables["control"], name.removeprefix("control."))
    if kind == "gain":
        return _ranked(find_metric(f"mma.x_abs_mean_m{{target={selection.parameters['target']}}}"), run)
    return _of_observations(selection, run.of_kind(kind)) if kind in SUBJECTS else None


def _of_observations(selection: Selection, observations: Observations) -> RankedRows:
    """Return the observations that a metric counts, with their errors by its definition."""
    definition = selection.definition
    used, value, weight = counted(selection, observations)
    share = definition.range == SHARE
    if definition.better == "more":
        error = weight * definition.range[1] - value
    else:
        error = np.zeros(len(value)) if share and not definition.better else np.abs(value) / weight
    shown = selection.column(definition.ranked_by or _with_sign(definition.value, selection, observations))
    if definition.ranked_by:
        error = np.where(error > 0.0, np.abs(observations[shown][used].astype(np.float64)), 0.0)
    rows = observations.table.iloc[used]
    rows = rows.assign(
        vehicle=observations["actor"][used] if "actor_id" in rows else "", shown=observations[shown][used]
    )
    subject = SUBJECTS[definition.kind]
    hides_value = share and shown == selection.column(definition.value) and definition.kind != "fit"
    words = "" if hides_value else f": {_words(shown)} {{:.3g}}{UNITS.get(shown.rpartition('_')[2], '')}"
    return RankedRows(rows, error, lambda row: subject(row) + words.format(row["shown"]))


def _with_sign(column: str, selection: Selection, observations: Observations) -> str:
    """Return the column of the errors with their sign, for a column of absolute errors that has one."""
    signed = column.replace("_abs", "")
    known = not pd.isna(observations[selection.column(signed)]).all()
    return signed if known else column


def _words(column: str) -> str:
    """Return the name of a column in words, without unit: `heading error`."""
    unit = column.rpartition("_")[2]
    return re.sub(r"_(abs_)?", " ", column.removesuffix(f"_{unit}") if unit in UNITS else column)


def _fit(row: Row) -> str:
    view = row["view"].replace("_", " ")
    return f"the {row['method']} rectangle on vehicle {row['vehicle']} ({view}, {row['range_m']:.0f} m)"


def _track(row: Row) -> str:
    model = "" if pd.isna(row["model"]) else f" ({row['model']}, truly {row['true_mode']})"
    return f"track {row['track_id']} on vehicle {row['vehicle']}{model}"


def _vehicle(row: Row) -> str:
    return f"vehicle {row['vehicle']} ({row['points']} points, {row['range_m']:.0f} m)"


def _segment(row: Row) -> str:
    return f"segment {row['segment']} ({row['points']} points)"


def _removal(row: Row) -> str:
    removed = f"{row['removed']} of {row['points']} points of cause {row['cause']} removed"
    return f"{removed}, and {row['clean_removed_beside']} clean points with them"


SUBJECTS: Mapping[str, Callable[[Row], str]] = {
    "fit": _fit,
    "track": _track,
    "vehicle": _vehicle,
    "traced_vehicle": _vehicle,
    "confirmation": _vehicle,
    "segment": _segment,
    "removal": _removal,
}
"""Description of an observation by its kind."""


def _of_drive(table: pd.DataFrame, measure: str) -> RankedRows:
    """Rank the frames of one drive by collisions, closeness to a collision, or braking of the ego."""
    driver = "truth" if measure.startswith(DRIVERS["truth"]) else "tracks"
    measure = measure.removeprefix(DRIVERS[driver])
    rows = table[table["driver"] == driver]
    if measure.startswith("max_deceleration"):
        braking = -rows["acceleration_mps2"].to_numpy(np.float64)
        return RankedRows(rows, braking, lambda row: f"it brakes at {row['error']:.1f} m/s^2")
    if measure == "collisions":
        return RankedRows(rows, rows["collides"].to_numpy(np.float64), lambda _: "the ego collides")
    distance = rows["gap_m" if measure.startswith("min_gap") else "ttc_s"].to_numpy(np.float64)

    def describe(row: Row) -> str:
        return f"{row['ttc_s']:.2f} s to a collision, {row['gap_m']:.1f} m away"

    return RankedRows(rows, 1.0 / np.maximum(distance, 1e-3), describe)


def _changes_of_track(truth: pd.DataFrame) -> RankedRows:
    """Rank vehicles by changes of the track that follows them."""
    followed = truth[truth["graded"] & (truth["track_id"] >= 0)].sort_values("frame", kind="stable")
    rows = followed.assign(before=followed.groupby("actor_id")["track_id"].shift())
    changed = rows["before"].notna() & (rows["before"] != rows["track_id"])

    def describe(row: Row) -> str:
        return f"vehicle {row['name']} goes from track {row['before']:.0f} to track {row['track_id']}"

    return RankedRows(rows, changed.to_numpy(np.float64), describe)


def _misses(run: RunObservations) -> RankedRows:
    """Rank frames by graded vehicles without a hit and tracks that hit none; new vehicles have little weight."""
    vehicles, tracks = run.clear.vehicles, run.clear.tracks
    missed, false = vehicles[~run.clear.is_hit], tracks[~run.clear.hits]
    age_s = missed["time_s"] - missed["actor_id"].map(vehicles.groupby("actor_id")["time_s"].min())
    error = pd.concat(
        [
            missed[["frame", "time_s"]].assign(error=np.where(age_s < CONFIRMATION_S, NEW_VEHICLE_WEIGHT, 1.0)),
            false[["frame", "time_s"]].assign(error=1.0),
        ]
    )
    rows = error.groupby(["frame", "time_s"], as_index=False)["error"].sum()

    def describe(row: Row) -> str:
        return _named_misses(run, *(table[table["frame"] == row["frame"]] for table in (missed, false)))

    return RankedRows(rows, rows["error"].to_numpy(np.float64), describe)


def _named_misses(run: RunObservations, missed: pd.DataFrame, false: pd.DataFrame) -> str:
    """Return how far the tracks of a frame overlap the vehicles that they do not hit, and tracks on no vehicle."""
    overlaps = run.tables["overlaps"]
    near = overlaps[overlaps["frame"].isin(missed["frame"]) & overlaps["track_id"].isin(false["track_id"])]
    best = near.sort_values("iou").drop_duplicates("actor_id", keep="last").set_index("actor_id")
    needed, explained, parts = f"a hit needs {run.config.hit_iou_min:g}", set[int](), list[str]()
    for actor, name in zip(missed["actor_id"], missed["name"], strict=True):
        if actor in best.index:
            track, iou = int(best.loc[actor, "track_id"]), best.loc[actor, "iou"]
            explained.add(track)
            parts.append(f"track {track} overlaps vehicle {name} by {iou:.2f}, {needed}")
        else:
            parts.append(f"no track overlaps vehicle {name}")
    parts += [f"track {track} hits no vehicle" for track in false["track_id"] if track not in explained]
    return listed(parts)

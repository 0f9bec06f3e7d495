"""Badness of the rows of a run's tables, per family of metrics, with a description of the error in a row.

`worst_frames` maps the name of a metric to one of these functions.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.grading import prediction_metrics
from luxloop.scenarios.grading.mode_metrics import MODE_OF
from luxloop.scenarios.grading.snapshots import CONFIRMATION_S
from luxloop.tracker.records import MODELS

Row = Mapping[str, Any]
"""A row of a table by column, its `badness`, and the name of its `vehicle` if it has an `actor_id`."""

NEW_VEHICLE_WEIGHT = 0.01
"""Badness of a vehicle without a track that was first graded less than `CONFIRMATION_S` ago."""

CONSISTENT = 2.0
"""Expected NEES and NIS of a consistent position estimate (2 degrees of freedom)."""


class RatedRows(NamedTuple):
    """Rows of a table with `frame` and `time_s`, and the badness of each."""

    rows: pd.DataFrame
    badness: pd.Series
    """Larger is worse; 0 and NaN mean no error."""
    describe: Callable[[Row], str]
    """Returns a description of the error in a row."""


def fits(table: pd.DataFrame, view: str, method: str, measure: str) -> RatedRows:
    """Rate the rectangles of one method, limited to one view if `view` names it."""
    rows = table[table[method]] if method in ("best", "oracle") else table[table["method"] == method]
    rows = rows[rows["view"] == view] if view else rows
    if measure == "coverage":
        missing = rows["heading_error_deg"].isna().astype(float)
        return RatedRows(rows, missing, lambda row: f"no rectangle {_vehicle(row)}")
    if measure.startswith("position"):
        error = rows["position_error_m"]
        return RatedRows(rows, error, lambda row: f"{_rectangle(row)} is {row['position_error_m']:.2f} m off")
    if measure.startswith("iou"):
        return RatedRows(rows, 1.0 - rows["iou"], lambda row: f"{_rectangle(row)} overlaps it by {row['iou']:.2f}")
    error = rows["heading_error_deg"].abs()
    return RatedRows(
        rows, error, lambda row: f"{_rectangle(row)} is {row['heading_error_deg']:+.1f} deg off in its fit heading"
    )


def _rectangle(row: Row) -> str:
    return f"the {row['method']} rectangle {_vehicle(row)}"


def _vehicle(row: Row) -> str:
    return f"on vehicle {row['vehicle']} ({row['view'].replace('_', ' ')}, {row['range_m']:.0f} m)"


def _track(row: Row) -> str:
    return f"track {row['track_id']} on vehicle {row['vehicle']}"


def _model(row: Row) -> str:
    return "" if pd.isna(row["model"]) else f", the model is {row['model']}"


def positions(tracks: pd.DataFrame, estimate: str, target: str, axes: str) -> RatedRows:
    """Rate the tracked corners of one estimate on standing or moving vehicles, along one or both axes of the ego."""
    judged = tracks[tracks["judged"]]
    standing = judged["true_mode"] == MODELS[0]
    rows = {"any": judged, "standing": judged[standing], "moving": judged[~standing]}[target]
    error = np.sqrt(sum(rows[f"{estimate}_{axis}_error_m"] ** 2 for axis in axes))

    def describe(row: Row) -> str:
        return f"{_track(row)} is {row['badness']:.2f} m off by {estimate}{_model(row)}"

    return RatedRows(rows, error, describe)


def predictions(truth: pd.DataFrame, tracks: pd.DataFrame, estimate: str, label: str, *, changing: bool) -> RatedRows:
    """Rate the predictions of one estimate by their distance from the corner at that time."""
    rows = tracks[tracks["judged"]]
    if changing:
        rows = rows[prediction_metrics.around_changes(rows, truth)]
    error = pd.Series(prediction_metrics.errors(rows, truth, estimate, label), index=rows.index)

    def describe(row: Row) -> str:
        return f"{_track(row)} is predicted {row['badness']:.2f} m off by {estimate}{_model(row)}"

    return RatedRows(rows, error, describe)


def modes(tracks: pd.DataFrame, *, standing_only: bool) -> RatedRows:
    """Rate the selected models: wrong mode, or only standing and moving confused."""
    rows = tracks[tracks["judged"]]
    true, chosen = rows["true_mode"].astype(str), rows["model"].astype(str).replace(MODE_OF)
    wrong = (chosen == MODELS[0]) != (true == MODELS[0]) if standing_only else chosen != true
    return RatedRows(
        rows, wrong.astype(float), lambda row: f"{_track(row)} is {row['model']}, truly {row['true_mode']}"
    )


def consistency(tracks: pd.DataFrame, column: str) -> RatedRows:
    """Rate NEES or NIS by the distance from the expected value, above or below."""
    rows = tracks[tracks["judged"]]
    far = np.log(rows[column].clip(lower=1e-9) / CONSISTENT).abs()
    name = column.replace("_", " ")
    return RatedRows(rows, far, lambda row: f"{_track(row)} has a {name} of {row[column]:.3g}, expected {CONSISTENT:g}")


def headings(tracks: pd.DataFrame) -> RatedRows:
    """Rate the headings of tracks on moving vehicles."""
    rows = tracks[tracks["judged"] & (tracks["true_mode"] != MODELS[0])]
    error = rows["heading_error_deg"]
    return RatedRows(
        rows, error.abs(), lambda row: f"{_track(row)} is {row['heading_error_deg']:+.1f} deg off in its track heading"
    )


def overlaps(tracks: pd.DataFrame) -> RatedRows:
    """Rate tracks by the overlap with their vehicle."""
    rows = tracks[tracks["judged"]]
    return RatedRows(rows, 1.0 - rows["iou"], lambda row: f"{_track(row)} overlaps it by {row['iou']:.2f}")


def split(truth: pd.DataFrame) -> RatedRows:
    """Rate vehicles by the share of points outside their largest segment."""
    rows = truth[truth["graded"]]

    def describe(row: Row) -> str:
        share = row["largest_segment_share"]
        return f"{share:.0%} of the {row['points']} points of vehicle {row['vehicle']} are in its largest segment"

    return RatedRows(rows, 1.0 - rows["largest_segment_share"], describe)


def merged(segments: pd.DataFrame) -> RatedRows:
    """Rate segments by the share of the second object in them."""

    def describe(row: Row) -> str:
        share = row["second_share"]
        return f"{share:.0%} of the {row['points']} points of segment {row['segment']} belong to another object"

    return RatedRows(segments, segments["second_share"], describe)


def outliers(table: pd.DataFrame, cause: str) -> RatedRows:
    """Rate the removal of one cause: its points that were kept, and clean points removed beside them."""
    rows = table[table["cause"] == cause]

    def describe(row: Row) -> str:
        return f"{row['removed']} of {row['points']} removed, and {row['clean_removed_beside']} clean points with them"

    return RatedRows(rows, rows["points"] - rows["removed"] + rows["clean_removed_beside"], describe)


def control(table: pd.DataFrame, driver: str, measure: str) -> RatedRows:
    """Rate the frames of one drive by collisions, closeness to a collision, or braking of the ego."""
    rows = table[table["driver"] == driver]
    if measure.startswith("max_deceleration"):
        return RatedRows(rows, -rows["acceleration_mps2"], lambda row: f"it brakes at {row['badness']:.1f} m/s^2")
    if measure == "collisions":
        return RatedRows(rows, rows["collides"].astype(float), lambda _: "the ego collides")
    column = "gap_m" if measure.startswith("min_gap") else "ttc_s"

    def describe(row: Row) -> str:
        return f"{row['ttc_s']:.2f} s to a collision, {row['gap_m']:.1f} m away"

    return RatedRows(rows, 1.0 / rows[column].clip(lower=1e-3), describe)


def identities(truth: pd.DataFrame) -> RatedRows:
    """Rate vehicles by changes of the track that follows them."""
    followed = truth[truth["graded"] & (truth["track_id"] >= 0)].sort_values("frame", kind="stable")
    rows = followed.assign(before=followed.groupby("actor_id")["track_id"].shift())
    changed = rows["before"].notna() & (rows["before"] != rows["track_id"])

    def describe(row: Row) -> str:
        return f"vehicle {row['vehicle']} goes from track {row['before']:.0f} to track {row['track_id']}"

    return RatedRows(rows, changed.astype(float), describe)


def detections(truth: pd.DataFrame, tracks: pd.DataFrame) -> RatedRows:
    """Rate frames by graded vehicles without a track and false tracks; new vehicles have little weight."""
    graded = truth[truth["graded"]]
    age_s = graded["time_s"] - graded.groupby("actor_id")["time_s"].transform("min")
    weight = np.where(age_s < CONFIRMATION_S, NEW_VEHICLE_WEIGHT, 1.0)
    missed = graded.assign(weight=weight)[graded["track_id"] < 0].groupby("frame")
    false = tracks[tracks["verdict"] == "false"].groupby("frame").size()
    frames = pd.concat([truth[["frame", "time_s"]], tracks[["frame", "time_s"]]]).drop_duplicates("frame")
    columns = {"missed": missed.size(), "weight": missed["weight"].sum(), "false": false}
    rows = frames.assign(**{name: frames["frame"].map(column).fillna(0) for name, column in columns.items()})

    def describe(row: Row) -> str:
        return f"{row['missed']:.0f} graded vehicles without a track, {row['false']:.0f} false tracks"

    return RatedRows(rows, rows["weight"] + rows["false"], describe)

"""How bad the rows of a run's tables are: each family of metrics has its rows, a number for each, and words for it."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from scenarios.grading.snapshots import PATIENCE_S
from tracker.records import MODELS

Row = Mapping[str, Any]
"""One row of a table by column, and its `badness`."""

NEWCOMER = 0.01
"""What a vehicle without a track counts that came into view less than `PATIENCE_S` ago: tracks take time to confirm."""

CONSISTENT = 2.0
"""NEES and NIS of a position that is as uncertain as it is said to be, in the mean."""


class Rated(NamedTuple):
    """Rows of a table with `frame` and `time_s`."""

    rows: pd.DataFrame
    badness: pd.Series
    """The larger the worse; 0 and NaN are not bad at all."""
    tell: Callable[[Row], str]
    """What is wrong in a row."""


def fits(table: pd.DataFrame, view: Sequence[str], method: str, measure: str) -> Rated:
    """Rectangles of one method, of one view if it is named."""
    rows = table[table[method]] if method in ("best", "oracle") else table[table["method"] == method]
    rows = rows[rows["view"] == view[0]] if view else rows
    if measure == "coverage":
        return Rated(rows, rows["heading_error_deg"].isna().astype(float), lambda row: f"no rectangle {_place(row)}")
    if measure.startswith("position"):
        return Rated(rows, rows["position_error_m"], lambda row: f"{_fit(row)} is {row['position_error_m']:.2f} m off")
    if measure.startswith("iou"):
        return Rated(rows, 1.0 - rows["iou"], lambda row: f"{_fit(row)} overlaps it by {row['iou']:.2f}")
    return Rated(
        rows, rows["heading_error_deg"].abs(), lambda row: f"{_fit(row)} is {row['heading_error_deg']:+.1f} deg off"
    )


def _fit(row: Row) -> str:
    return f"the {row['method']} rectangle {_place(row)}"


def _place(row: Row) -> str:
    return f"on vehicle {row['actor_id']} ({row['view'].replace('_', ' ')}, {row['range_m']:.0f} m)"


def _track(row: Row) -> str:
    return f"track {row['track_id']} on vehicle {row['actor_id']}"


def positions(tracks: pd.DataFrame, estimate: str, target: str, axes: str) -> Rated:
    """Tracked corners on standing or moving vehicles, by one estimate, along one axis of the ego or both."""
    judged = tracks[tracks["judged"]]
    standing = judged["true_mode"] == MODELS[0]
    rows = judged[standing if target.startswith("stationary") else ~standing]
    error = np.sqrt(sum(rows[f"{estimate}_{axis}_error_m"] ** 2 for axis in axes))

    def tell(row: Row) -> str:
        return f"{_track(row)} is {row['badness']:.2f} m off by {estimate}, the model is {row['model']}"

    return Rated(rows, error, tell)


def modes(tracks: pd.DataFrame, *, standing_only: bool) -> Rated:
    """Selected models that are not the true mode, or take what stands for what moves."""
    rows = tracks[tracks["judged"]]
    true, chosen = rows["true_mode"].astype(str), rows["model"].astype(str)
    wrong = (chosen == MODELS[0]) != (true == MODELS[0]) if standing_only else chosen != true
    return Rated(rows, wrong.astype(float), lambda row: f"{_track(row)} is {row['model']}, truly {row['true_mode']}")


def consistency(tracks: pd.DataFrame, column: str) -> Rated:
    """NEES or NIS far from what is expected, above or below."""
    rows = tracks[tracks["judged"]]
    far = np.log(rows[column].clip(lower=1e-9) / CONSISTENT).abs()
    name = column.replace("_", " ")
    return Rated(rows, far, lambda row: f"{_track(row)} has a {name} of {row[column]:.3g}, {CONSISTENT:g} is expected")


def headings(tracks: pd.DataFrame) -> Rated:
    """Headings of tracks on moving vehicles."""
    rows = tracks[tracks["judged"] & (tracks["true_mode"] != MODELS[0])]
    error = rows["heading_error_deg"]
    return Rated(rows, error.abs(), lambda row: f"{_track(row)} points {row['heading_error_deg']:+.1f} deg off")


def overlaps(tracks: pd.DataFrame) -> Rated:
    """Tracks that fit their vehicle badly."""
    rows = tracks[tracks["judged"]]
    return Rated(rows, 1.0 - rows["iou"], lambda row: f"{_track(row)} overlaps it by {row['iou']:.2f}")


def split(truth: pd.DataFrame) -> Rated:
    """Vehicles of which the largest segment holds little."""
    rows = truth[truth["graded"]]

    def tell(row: Row) -> str:
        share = row["largest_segment_share"]
        return f"{share:.0%} of the {row['points']} points of vehicle {row['actor_id']} are in its largest segment"

    return Rated(rows, 1.0 - rows["largest_segment_share"], tell)


def merged(segments: pd.DataFrame) -> Rated:
    """Segments that hold much of something else, too."""

    def tell(row: Row) -> str:
        return f"{row['second_share']:.0%} of the {row['points']} points of segment {row['segment']} are something else"

    return Rated(segments, segments["second_share"], tell)


def outliers(table: pd.DataFrame, cause: str) -> Rated:
    """Points of a cause that were kept, and clean ones that were removed with it."""
    rows = table[table["cause"] == cause]

    def tell(row: Row) -> str:
        return f"{row['removed']} of {row['points']} removed, and {row['clean_removed_beside']} clean points with them"

    return Rated(rows, rows["points"] - rows["removed"] + rows["clean_removed_beside"], tell)


def control(table: pd.DataFrame, driver: str, measure: str) -> Rated:
    """Frames of one drive in which a collision is near, or there is one, or the ego brakes hard."""
    rows = table[table["driver"] == driver]
    if measure.startswith("max_deceleration"):
        return Rated(rows, -rows["acceleration_mps2"], lambda row: f"it brakes at {row['badness']:.1f} m/s^2")
    if measure == "collisions":
        return Rated(rows, rows["collides"].astype(float), lambda _: "it hits somebody")
    column = "gap_m" if measure.startswith("min_gap") else "ttc_s"

    def tell(row: Row) -> str:
        return f"{row['ttc_s']:.2f} s to a collision, {row['gap_m']:.1f} m away"

    return Rated(rows, 1.0 / rows[column].clip(lower=1e-3), tell)


def identities(truth: pd.DataFrame) -> Rated:
    """Vehicles that are followed by another track than when they were last followed."""
    followed = truth[truth["graded"] & (truth["track_id"] >= 0)].sort_values("frame", kind="stable")
    rows = followed.assign(before=followed.groupby("actor_id")["track_id"].shift())
    changed = rows["before"].notna() & (rows["before"] != rows["track_id"])

    def tell(row: Row) -> str:
        return f"vehicle {row['actor_id']} goes from track {row['before']:.0f} to track {row['track_id']}"

    return Rated(rows, changed.astype(float), tell)


def detections(truth: pd.DataFrame, tracks: pd.DataFrame) -> Rated:
    """Graded vehicles without a track and tracks on nothing, by frame; newcomers without one weigh little."""
    graded = truth[truth["graded"]]
    age_s = graded["time_s"] - graded.groupby("actor_id")["time_s"].transform("min")
    lost = graded.assign(weight=np.where(age_s < PATIENCE_S, NEWCOMER, 1.0))[graded["track_id"] < 0].groupby("frame")
    false = tracks[tracks["verdict"] == "false"].groupby("frame").size()
    frames = pd.concat([truth[["frame", "time_s"]], tracks[["frame", "time_s"]]]).drop_duplicates("frame")
    columns = {"missed": lost.size(), "weight": lost["weight"].sum(), "false": false}
    rows = frames.assign(**{name: frames["frame"].map(column).fillna(0) for name, column in columns.items()})

    def tell(row: Row) -> str:
        return f"{row['missed']:.0f} graded vehicles without a track, {row['false']:.0f} tracks on nothing"

    return Rated(rows, rows["weight"] + rows["false"], tell)

"""Metrics of people and riders: tracks of their size, scores, misses and errors.

A track is matched by the distance of the centres: a person of 0.5 m has no rectangle at the resolution of the rig, and
an overlap would only measure its noise. HOTA, CLEAR and Identity use the similarity of points, 1 - distance /
match_distance_m, as in trackeval.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from luxloop.arrays import Bools, Ints
from luxloop.scenarios.grading import track_metrics, tracking_scores
from luxloop.scenarios.grading.clear_table import (
    ClearTable,
    HitStep,
    TrackingSequence,
    clear_hits,
    clear_table,
    tracking_sequence,
)
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.matching import CONTINUITY
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.tracking_scores import VehicleScores
from luxloop.scenarios.metrics.definition import band
from luxloop.scenarios.metrics.definitions import DEFINITIONS, GROUPS, VULNERABLE_COUNTS, VULNERABLE_SCORES
from luxloop.sensor_model.truth import NO_ACTOR

SMALL, VEHICLE = "small", "vehicle"
"""Names of the classes that a tracker gives to its tracks, in the column `label` of the table `tracks`."""


class SmallTracks(NamedTuple):
    """Tracks that may be on people or riders, and their distances."""

    tracks: pd.DataFrame
    """Rows of the table `tracks`, with `on`, the actor that the track is on, or `NO_ACTOR`, and `near`, the nearest
    person or rider within `match_distance_m`, or `NO_ACTOR`."""
    pairs: pd.DataFrame
    """A row per frame, actor and track within `match_distance_m`: `actor_id`, `track_id`, `distance_m`, and `iou`, the
    similarity 1 - distance / match_distance_m."""


def small_tracks(
    truth: pd.DataFrame, tracks: pd.DataFrame, overlaps: pd.DataFrame, config: GradingConfig
) -> SmallTracks:
    """Return the confirmed tracks that may be on people or riders.

    A track that the tracker calls a vehicle, or that follows an actor of another class, is none. A tracker that does
    not tell small road users from vehicles can only be right: its tracks count where they are near a person or rider.

    Parameters
    ----------
    truth, tracks, overlaps
        Tables of a run.
    """
    users = truth[truth["kind"].isin(list(GROUPS.values()))]
    others = truth.loc[~truth["kind"].isin(list(GROUPS.values())), "actor_id"].unique()
    label = tracks["label"].astype(object)
    candidates = tracks[(tracks["status"] == "confirmed") & (label != VEHICLE) & ~tracks["actor_id"].isin(others)]
    pairs = _pairs(users, candidates, config.match_distance_m)
    candidates = candidates.assign(on=_assigned(candidates, pairs), near=_nearest(candidates, pairs))
    elsewhere = candidates["near"] == NO_ACTOR
    on_other = _rows_in(candidates, overlaps[overlaps["actor_id"].isin(others)])
    unknown = candidates["label"].isna()
    outside = candidates["range_m"] > config.vulnerable_range_max_m
    return SmallTracks(candidates[~(elsewhere & (on_other | unknown | outside))], pairs)


def _pairs(users: pd.DataFrame, candidates: pd.DataFrame, reach_m: float) -> pd.DataFrame:
    """Return the pairs within `reach_m` [m], with their distances and similarities."""
    place = ["x_world_m", "y_world_m"]
    pairs = users[["frame", "actor_id", *place]].merge(
        candidates[["frame", "track_id", *place]], on="frame", suffixes=("", "_track")
    )
    offset = pairs[place].to_numpy(np.float64) - pairs[[f"{name}_track" for name in place]].to_numpy(np.float64)
    distance = np.hypot(offset[:, 0], offset[:, 1])
    pairs = pairs[["frame", "actor_id", "track_id"]].assign(distance_m=distance, iou=1.0 - distance / reach_m)
    return pairs[pairs["iou"] > 0.0]


def _assigned(candidates: pd.DataFrame, pairs: pd.DataFrame) -> Ints:
    """(n,) actor that each track is on: one to one, pairs of the last frame first, then the nearest ones."""
    before: dict[int, int] = {}
    found: dict[tuple[int, int], int] = {}
    for frame, rows in pairs.groupby("frame", sort=True):
        actors, actor = np.unique(rows["actor_id"], return_inverse=True)
        tracks, track = np.unique(rows["track_id"], return_inverse=True)
        score = np.zeros((len(actors), len(tracks)))
        score[actor, track] = rows["iou"]
        kept = np.array([before.get(one, NO_ACTOR) for one in tracks.tolist()])
        score += CONTINUITY * ((actors[:, None] == kept) & (score > 0.0))
        row, column = scipy.optimize.linear_sum_assignment(score, maximize=True)
        paired = score[row, column] > 0.0
        before = dict(zip(tracks[column[paired]].tolist(), actors[row[paired]].tolist(), strict=True))
        found |= {(int(frame), one): on for one, on in before.items()}
    keys = zip(candidates["frame"].tolist(), candidates["track_id"].tolist(), strict=True)
    return np.array([found.get(key, NO_ACTOR) for key in keys], dtype=np.int64)


def _nearest(candidates: pd.DataFrame, pairs: pd.DataFrame) -> Ints:
    """(n,) nearest person or rider within reach of each track."""
    nearest = pairs.sort_values("distance_m", kind="stable").drop_duplicates(["frame", "track_id"])
    actor = nearest.set_index(["frame", "track_id"])["actor_id"]
    keys = pd.MultiIndex.from_frame(candidates[["frame", "track_id"]])
    return np.asarray(actor.reindex(keys).fillna(NO_ACTOR), dtype=np.int64)


def _rows_in(candidates: pd.DataFrame, rows: pd.DataFrame) -> pd.Series:
    """(n,) mask of the tracks that have a row in their frame."""
    keys = pd.MultiIndex.from_frame(candidates[["frame", "track_id"]])
    return pd.Series(keys.isin(pd.MultiIndex.from_frame(rows[["frame", "track_id"]])), index=candidates.index)


HIT_SIMILARITY = 0.5
"""Least similarity of a hit: half of `match_distance_m`."""
NO_CLASSES = "the tracker does not distinguish small road users from vehicles"


def grade_vulnerable(
    sheet: MetricSheet,
    truth: pd.DataFrame,
    tracks: pd.DataFrame,
    overlaps: pd.DataFrame,
    config: GradingConfig,
    filters: Mapping[str, str],
) -> None:
    """Enter the metrics of people and riders; a filter by range applies to the share of missed ones only.

    Parameters
    ----------
    truth, tracks, overlaps
        Tables of the run.
    """
    why = {group: f"no {group} were graded" for group in GROUPS}
    if not (truth["vulnerable"].any() or (tracks["label"] == SMALL).any()):
        _write_none(sheet, why, len(truth))
        return
    truth = truth.assign(graded=truth["vulnerable"])
    found = small_tracks(truth, tracks, overlaps, config)
    labelled = bool(tracks["label"].notna().any()) or not len(tracks)
    for group in GROUPS:
        within = band(filters["range"]) if filters else (0.0, np.inf)
        _grade_group(sheet, group, truth, tracks, found, within, labelled=labelled, why=why[group])


def _write_none(sheet: MetricSheet, why: Mapping[str, str], rows: int) -> None:
    """Enter metrics without a value, for a run without such actors and tracks; `rows` is the number of actors."""
    for definition in DEFINITIONS.values():
        if definition.kind in GROUPS:
            counted = definition.name.endswith(".observations")
            sheet.write(definition.name, 0, rows if counted else 0, why[definition.kind])


def _grade_group(
    sheet: MetricSheet,
    group: str,
    truth: pd.DataFrame,
    tracks: pd.DataFrame,
    found: SmallTracks,
    within: tuple[float, float],
    *,
    labelled: bool,
    why: str,
) -> None:
    """Enter the metrics of one group, missed ones within a band of the range [m].

    `labelled` is True if tracks have classes.
    """
    users = truth.assign(graded=truth["graded"] & (truth["kind"] == GROUPS[group]))
    counted = _counted(users, found)
    sequence = tracking_sequence(users, counted, found.pairs)
    hits = list(clear_hits(sequence, HIT_SIMILARITY))
    clear = clear_table(users, counted, sequence, hits)
    sheet.write(f"{group}.observations", len(clear.vehicles), len(truth), why)
    _grade_scores(sheet, group, sequence, hits, clear, labelled=labelled, why=why)
    _grade_misses(sheet, group, clear, tracks, within, labelled=labelled, why=why)
    _grade_errors(sheet, group, clear, sequence, hits)


def _counted(users: pd.DataFrame, found: SmallTracks) -> pd.DataFrame:
    """Return the tracks that count for the graded ones of `users`, with a verdict as of the table `tracks`.

    A track on an actor that is not among them, of the other group or not graded, is neither right nor wrong. A track on
    nothing counts as false in both groups: the tracker does not tell them apart.
    """
    tracks = found.tracks
    graded = pd.MultiIndex.from_frame(users.loc[users["graded"], ["frame", "actor_id"]])
    on, near = (pd.MultiIndex.from_frame(tracks[["frame", column]]).isin(graded) for column in ("on", "near"))
    second = (tracks["on"] == NO_ACTOR).to_numpy() & near
    false = second | (tracks["near"] == NO_ACTOR).to_numpy()
    verdict = np.select([on, false], ["graded", "false"], "ungraded")
    return tracks.assign(verdict=verdict, actor_id=tracks["on"])


def _grade_scores(
    sheet: MetricSheet,
    group: str,
    sequence: TrackingSequence,
    hits: list[HitStep],
    clear: ClearTable,
    *,
    labelled: bool,
    why: str,
) -> None:
    """Enter HOTA, CLEAR and Identity."""
    sums = VehicleScores.of(sequence, HIT_SIMILARITY, hits)
    scores = tracking_scores.TrackingScores.of(sums)
    followed = clear.tracks["actor_id"].where(clear.tracks["verdict"] == "graded", NO_ACTOR).to_numpy()
    interval = tracking_scores.intervals(sequence, sums, followed)
    users = sequence["num_gt_dets"]
    for name in (*VULNERABLE_SCORES, *VULNERABLE_COUNTS):
        if name != "false":
            value, found = getattr(scores, name), interval.get(f"track.{name}")
            sheet.write(f"{group}.{name}", value, users, why, found, tracking_scores.why_no_interval(name, value))
    sheet.write(
        f"{group}.false", scores.false if labelled else None, max(users, scores.false), why if labelled else NO_CLASSES
    )


def _grade_misses(
    sheet: MetricSheet,
    group: str,
    clear: ClearTable,
    tracks: pd.DataFrame,
    within: tuple[float, float],
    *,
    labelled: bool,
    why: str,
) -> None:
    """Enter missed ones, those that a track of a vehicle follows, and the times to confirm."""
    users, missed = clear.vehicles, ~clear.is_hit
    names = users["actor_id"].to_numpy()
    distance = users["range_m"].to_numpy(np.float64)
    inside = (distance >= within[0]) & (distance < within[1])
    reason = "no observation has this range" if len(users) and not inside.any() else why
    sheet.mean(f"{group}.missed_share", missed[inside], reason, names[inside])
    called = _called_vehicles(users, tracks)
    sheet.mean(
        f"{group}.called_vehicle_share",
        called if labelled else called[:0],
        why if labelled else NO_CLASSES,
        names[: len(called) if labelled else 0],
    )
    found = track_metrics.waits(clear)
    wait = found["wait_s"].to_numpy()
    median = float(np.quantile(wait, 0.5, method="inverted_cdf")) if len(wait) else np.inf
    finite = bool(np.isfinite(median))
    reason = f"too many {group} were never confirmed" if len(wait) else why
    sheet.write(f"{group}.time_to_confirm_s", median if finite else None, len(wait), reason)
    sheet.mean(f"{group}.never_confirmed", np.isinf(wait), why, found["actor_id"].to_numpy())


def _called_vehicles(users: pd.DataFrame, tracks: pd.DataFrame) -> Bools:
    """(n,) mask of the graded ones that a confirmed track of a vehicle follows."""
    vehicles = tracks[(tracks["status"] == "confirmed") & (tracks["label"].astype(object) == VEHICLE)]
    followed = pd.MultiIndex.from_frame(vehicles[["frame", "actor_id"]])
    return np.asarray(pd.MultiIndex.from_frame(users[["frame", "actor_id"]]).isin(followed), dtype=np.bool_)


def _grade_errors(
    sheet: MetricSheet, group: str, clear: ClearTable, sequence: TrackingSequence, hits: list[HitStep]
) -> None:
    """Enter the errors of position and velocity of all hits."""
    track_ids = np.unique(clear.tracks["track_id"])
    steps = [
        pd.DataFrame(
            {
                "frame": sequence["frames"][step],
                "actor_id": sequence["actor_ids"][actor],
                "track_id": track_ids[track],
            }
        )
        for step, actor, track in hits
    ]
    rows = (
        pd.concat(steps, ignore_index=True) if steps else clear.vehicles[["frame", "actor_id"]][:0].assign(track_id=0)
    )
    state = ["x_world_m", "y_world_m", "vx_world_mps", "vy_world_mps"]
    true = rows.merge(clear.vehicles, how="left", on=["frame", "actor_id"])[state].to_numpy(np.float64)
    tracked = rows.merge(clear.tracks, how="left", on=["frame", "track_id"])[state].to_numpy(np.float64)
    error, names, why = tracked - true, rows["actor_id"].to_numpy(), f"no track hits one of the {group}"
    speed = np.abs(np.hypot(*tracked[:, 2:].T) - np.hypot(*true[:, 2:].T))
    known = np.isfinite(speed)
    sheet.mean(f"{group}.position_abs_mean_m", np.hypot(*error[:, :2].T), why, names)
    for name, values in {"velocity": np.hypot(*error[:, 2:].T), "speed": speed}.items():
        sheet.mean(f"{group}.{name}_abs_mean_mps", values[known], why, names[known])

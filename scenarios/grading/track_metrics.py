"""Metrics of tracks: scores, missed vehicles, false tracks, and times until confirmation."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading import tracking_scores
from luxloop.scenarios.grading.clear_table import ClearTable, IdSwitch, TrackingSequence, id_switches
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.tracking_scores import VehicleScores
from luxloop.scenarios.metrics.definitions import CLASSES, NO_TRACK, NO_VEHICLE
from luxloop.sensor_model.truth import NO_ACTOR

if TYPE_CHECKING:
    from luxloop.scenarios.grading.observations import RunObservations


def waits(clear: ClearTable) -> pd.DataFrame:
    """Return a row per vehicle: that of its first graded frame, with `wait_s` until the first hit [s].

    It is infinite, and `never` true, without a hit.
    """
    vehicles = clear.vehicles.sort_values("frame", kind="stable")
    first = vehicles.drop_duplicates("actor_id")
    hit = clear.vehicles[clear.is_hit].groupby("actor_id")["time_s"].min()
    never = ~first["actor_id"].isin(hit.index)
    wait = first["actor_id"].map(hit) - first["time_s"]
    return first.assign(never=never, wait_s=wait.astype(np.float64).mask(never, np.inf))


KEY = ["frame", "track_id"]


def grade(sheet: MetricSheet, run: "RunObservations") -> None:
    """Enter every figure of the kind `score`."""
    sequence, clear = run.sequence, run.clear
    of_vehicles = VehicleScores.of(sequence, run.config.hit_iou_min, run.hits)
    scores = tracking_scores.TrackingScores.of(of_vehicles)
    followed = clear.tracks["actor_id"].where(clear.tracks["verdict"] == "graded", NO_ACTOR).to_numpy()
    interval = tracking_scores.intervals(sequence, of_vehicles, followed)
    vehicles, reported = sequence["num_gt_dets"], sequence["num_tracker_dets"]
    for name in ("hota", "deta", "assa", "mota", "idf1", "id_switches", "fragments", "missed"):
        value, found = getattr(scores, name), interval.get(f"track.{name}")
        sheet.write(f"track.{name}", value, vehicles, NO_VEHICLE, found, tracking_scores.why_no_interval(name, value))
    sheet.rate("track.id_switch_rate", scores.id_switches, vehicles, NO_VEHICLE)
    sheet.write("track.loca", scores.loca, scores.most_matches, "no track overlaps a graded vehicle")
    sheet.write("track.false", scores.false, reported, NO_TRACK)
    switches = id_switches(sequence["num_gt_ids"], run.hits)
    in_view = sum(_in_view(switch, sequence, run.truth, run.config.hidden_fraction_max) for switch in switches)
    sheet.write("track.id_switches_in_view", in_view, vehicles, NO_VEHICLE)
    _grade_false(sheet, clear, run.truth, run.tables["overlaps"], run.config.hit_iou_min)


def _in_view(switch: IdSwitch, sequence: TrackingSequence, truth: pd.DataFrame, hidden_fraction_max: float) -> bool:
    """Return True if the vehicle was in view from the last hit of the old track to the first of the new one.

    In view: present in every frame, with a visible fraction above `hidden_fraction_max` in each. The cause of a smaller
    fraction does not matter, be it an occluder or the rig's blind spot.
    """
    actor_id = sequence["actor_ids"][switch.vehicle]
    first, last = sequence["frames"][switch.before], sequence["frames"][switch.step]
    between = truth[(truth["actor_id"] == actor_id) & truth["frame"].between(first, last)]
    visible = between["visible_fraction"] > hidden_fraction_max
    return len(between) == last - first + 1 and bool(visible.all())


def _grade_false(
    sheet: MetricSheet, clear: ClearTable, truth: pd.DataFrame, overlaps: pd.DataFrame, hit_iou_min: float
) -> None:
    """Enter the numbers of false tracks of each kind, and the share of all.

    The three kinds add up to `track.false`. Vehicles that are not graded count, too: a box on a part of them is not on
    nothing.
    """
    false = clear.tracks[~clear.hits]
    is_vehicle = truth["kind"].isin(CLASSES) | truth["graded"]  # graded boxes of files may be of any class
    of_vehicle = overlaps[overlaps["actor_id"].isin(truth.loc[is_vehicle, "actor_id"])]
    graded = of_vehicle.merge(clear.vehicles[["frame", "actor_id"]], on=["frame", "actor_id"])
    nothing = _largest(of_vehicle, false) == 0.0
    duplicate = _largest(graded, false) >= hit_iou_min
    counts = {"on_nothing": nothing, "ill_fitting": ~nothing & ~duplicate, "duplicate": duplicate}
    for name, rows in counts.items():
        sheet.write(f"track.false_{name}", int(rows.sum()), len(clear.tracks), NO_TRACK)
    sheet.rate("track.false_share", len(false), len(clear.vehicles), NO_VEHICLE)


def _largest(overlaps: pd.DataFrame, tracks: pd.DataFrame) -> Floats:
    """(n,) largest overlap of each track, 0 without any."""
    largest = overlaps.groupby(KEY)["iou"].max().reindex(pd.MultiIndex.from_frame(tracks[KEY]))
    return np.asarray(largest.fillna(0.0), dtype=np.float64)

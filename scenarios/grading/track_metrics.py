"""Tracking metrics of a run except occlusion survival: HOTA, CLEAR, Identity, and the metrics of the other modules."""

import pandas as pd

from luxloop.scenarios.grading import (
    confirmation_metrics,
    false_track_metrics,
    gospa_metrics,
    miss_metrics,
    motion_metrics,
    score_sums,
)
from luxloop.scenarios.grading.clear_table import ClearTable, clear_table
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.id_switches import HitStep, IdSwitch, clear_hits, id_switches
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.tracking_scores import VehicleScores
from luxloop.scenarios.grading.tracking_sequence import TrackingSequence, tracking_sequence
from luxloop.sensor_model.truth import NO_ACTOR

NO_TRUTH = "no vehicle was graded"


def grade(
    sheet: MetricSheet,
    truth: pd.DataFrame,
    tracks: pd.DataFrame,
    overlaps: pd.DataFrame,
    config: GradingConfig,
) -> None:
    """Enter the `track` metrics except occlusion survival.

    Parameters
    ----------
    truth, tracks, overlaps
        Tables of the run.
    """
    sequence = tracking_sequence(truth, tracks, overlaps)
    hits = list(clear_hits(sequence, config.hit_iou_min))
    clear = clear_table(truth, tracks, sequence, hits)
    _grade_scores(sheet, sequence, hits, clear, config)
    vehicles = sequence["num_gt_dets"]
    switches = id_switches(sequence["num_gt_ids"], hits)
    in_view = sum(_in_view(switch, sequence, truth, config.hidden_fraction_max) for switch in switches)
    sheet.write("track.id_switches_in_view", in_view, vehicles, NO_TRUTH)
    false_track_metrics.grade(sheet, clear, truth, overlaps, config.hit_iou_min)
    miss_metrics.grade(sheet, clear, truth)
    confirmation_metrics.grade(sheet, clear)
    gospa_metrics.grade(sheet, clear.vehicles, clear.tracks, config.gospa_cutoff_m)
    motion_metrics.grade(sheet, truth, tracks)


def _grade_scores(
    sheet: MetricSheet, sequence: TrackingSequence, hits: list[HitStep], clear: ClearTable, config: GradingConfig
) -> None:
    """Enter HOTA, CLEAR and Identity, with intervals for the main scores."""
    of_vehicles = VehicleScores.of(sequence, config.hit_iou_min, hits)
    scores = score_sums.TrackingScores.of(of_vehicles)
    followed = clear.tracks["actor_id"].where(clear.tracks["verdict"] == "graded", NO_ACTOR).to_numpy()
    interval = score_sums.intervals(sequence, of_vehicles, followed)
    vehicles, reported = sequence["num_gt_dets"], sequence["num_tracker_dets"]
    for name in ("hota", "deta", "assa", "mota", "idf1", "id_switches", "fragments", "missed"):
        value, found = getattr(scores, name), interval.get(f"track.{name}")
        sheet.write(f"track.{name}", value, vehicles, NO_TRUTH, found, score_sums.why_no_interval(name, value))
    sheet.write("track.loca", scores.loca, scores.most_matches, "no track overlaps a graded vehicle")
    sheet.write("track.false", scores.false, reported, "no track was reported in the graded range")


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

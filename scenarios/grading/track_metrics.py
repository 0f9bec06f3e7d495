"""Tracking metrics of a run except occlusion survival: HOTA, CLEAR, Identity, and heading modulo 360 degrees."""

import pandas as pd

from scenarios.grading.grading_config import GradingConfig
from scenarios.grading.id_switches import IdSwitch, id_switches
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.tracking_scores import TrackingScores
from scenarios.grading.tracking_sequence import TrackingSequence, tracking_sequence
from tracker.records import MODELS

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
    scores = TrackingScores.of(sequence, config.hit_iou_min)
    vehicles, reported = sequence["num_gt_dets"], sequence["num_tracker_dets"]
    sheet.write("track.hota", scores.hota, vehicles, NO_TRUTH)
    sheet.write("track.deta", scores.deta, vehicles, NO_TRUTH)
    sheet.write("track.assa", scores.assa, vehicles, NO_TRUTH)
    sheet.write("track.loca", scores.loca, scores.most_matches, "no track overlaps a graded vehicle")
    sheet.write("track.mota", scores.mota, vehicles, NO_TRUTH)
    sheet.write("track.idf1", scores.idf1, vehicles, NO_TRUTH)
    sheet.write("track.id_switches", scores.id_switches, vehicles, NO_TRUTH)
    sheet.write("track.id_switches_in_view", _switches_in_view(sequence, truth, config), vehicles, NO_TRUTH)
    sheet.write("track.fragments", scores.fragments, vehicles, NO_TRUTH)
    sheet.write("track.missed", scores.missed, vehicles, NO_TRUTH)
    sheet.write("track.false", scores.false, reported, "no track was reported in the graded range")
    _grade_heading(sheet, tracks)


def _switches_in_view(sequence: TrackingSequence, truth: pd.DataFrame, config: GradingConfig) -> int:
    """Count the id switches that no occlusion excuses."""
    switches = id_switches(sequence, config.hit_iou_min)
    return sum(_in_view(switch, sequence, truth, config.hidden_fraction_max) for switch in switches)


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


def _grade_heading(sheet: MetricSheet, tracks: pd.DataFrame) -> None:
    """Enter the heading metrics of moving vehicles; the outline of a parked car does not show its front."""
    judged = tracks["judged"] & (tracks["true_mode"] != MODELS[0])
    error = tracks.loc[judged, "heading_error_deg"].abs().to_numpy()
    why = "no confirmed track followed a moving graded vehicle"
    sheet.mean("track.heading_abs_mean_deg", error, why)
    sheet.mean("track.heading_flip_rate", error > 90.0, why)

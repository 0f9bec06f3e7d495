"""How well vehicles are followed: HOTA, CLEAR and Identity by trackeval, and the heading modulo 360 degrees."""

from typing import Any

import numpy as np
import pandas as pd

from scenarios.arrays import Floats
from scenarios.grading.grading_config import GradingConfig
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.switches import in_view, switches
from tracker.records import MODELS

NO_TRUTH = "no vehicle was graded"


def sequence(truth: pd.DataFrame, tracks: pd.DataFrame, overlaps: pd.DataFrame) -> dict[str, Any]:
    """Gather what trackeval's metric classes take: per frame the graded vehicles, the tracks, and their overlaps.

    Only tracks on graded vehicles and false ones are in it. Ids are renumbered from 0, as trackeval expects; `frames`
    and `actor_ids`, which it does not read, tell the frame of a time step and the id of a vehicle.
    """
    vehicles = truth.loc[truth["graded"], ["frame", "actor_id"]]
    reported = tracks.loc[tracks["verdict"].isin(["graded", "false"]), ["frame", "track_id"]]
    actor_ids, track_ids = np.unique(vehicles["actor_id"]), np.unique(reported["track_id"])
    frames = np.unique(np.concatenate([truth["frame"], tracks["frame"]]))
    gt = _split(vehicles, "actor_id", actor_ids, frames)
    seen = _split(reported, "track_id", track_ids, frames)
    return {
        "frames": frames,
        "actor_ids": actor_ids,
        "num_timesteps": len(frames),
        "num_gt_ids": len(actor_ids),
        "num_tracker_ids": len(track_ids),
        "num_gt_dets": len(vehicles),
        "num_tracker_dets": len(reported),
        "gt_ids": gt,
        "tracker_ids": seen,
        "similarity_scores": _similarity(overlaps, frames, gt, seen, actor_ids, track_ids),
    }


def _split(rows: pd.DataFrame, column: str, ids: Any, frames: Any) -> list[Any]:
    """One array of renumbered ids per frame."""
    rows = rows.sort_values("frame", kind="stable")
    renumbered = np.searchsorted(ids, rows[column].to_numpy())
    return np.split(renumbered, np.searchsorted(rows["frame"].to_numpy(), frames[1:]))


def _similarity(
    overlaps: pd.DataFrame, frames: Any, gt: list[Any], seen: list[Any], actor_ids: Any, track_ids: Any
) -> list[Floats]:
    """One (vehicles, tracks) table of overlaps per frame."""
    known = overlaps["actor_id"].isin(actor_ids) & overlaps["track_id"].isin(track_ids)
    rows = overlaps[known].sort_values("frame", kind="stable")
    bounds = np.searchsorted(rows["frame"].to_numpy(), frames[1:])
    actor = np.split(np.searchsorted(actor_ids, rows["actor_id"].to_numpy()), bounds)
    track = np.split(np.searchsorted(track_ids, rows["track_id"].to_numpy()), bounds)
    iou = np.split(rows["iou"].to_numpy(), bounds)
    tables = []
    whole = np.zeros((len(actor_ids), len(track_ids)))
    for t in range(len(frames)):
        whole[actor[t], track[t]] = iou[t]
        tables.append(whole[np.ix_(gt[t], seen[t])])
        whole[actor[t], track[t]] = 0.0
    return tables


def grade(
    sheet: MetricSheet,
    truth: pd.DataFrame,
    tracks: pd.DataFrame,
    overlaps: pd.DataFrame,
    config: GradingConfig,
) -> None:
    """Enter the `track` metrics but occlusion survival.

    trackeval counts a fragment also where a vehicle leaves the books (hidden, out of range) and comes back: every
    stretch of unbroken hits after the first is one.
    """
    from trackeval.metrics import CLEAR, HOTA, Identity  # slow to import

    data = sequence(truth, tracks, overlaps)
    limits = {"THRESHOLD": config.hit_iou_min, "PRINT_CONFIG": False}
    hota = HOTA().eval_sequence(data)
    clear = CLEAR(dict(limits)).eval_sequence(data)
    identity = Identity(dict(limits)).eval_sequence(data)

    vehicles, reported = data["num_gt_dets"], data["num_tracker_dets"]
    for name in ("HOTA", "DetA", "AssA"):
        sheet.write(f"track.{name.lower()}", float(np.mean(hota[name])), vehicles, NO_TRUTH)
    hits = int(hota["HOTA_TP"].max())
    sheet.write("track.loca", float(np.mean(hota["LocA"])), hits, "no track overlaps a graded vehicle")
    sheet.write("track.mota", float(clear["MOTA"]), vehicles, NO_TRUTH)
    sheet.write("track.idf1", float(identity["IDF1"]), vehicles, NO_TRUTH)
    sheet.write("track.id_switches", float(clear["IDSW"]), vehicles, NO_TRUTH)
    sheet.write("track.id_switches_in_view", _switches_in_view(data, truth, config), vehicles, NO_TRUTH)
    sheet.write("track.fragments", float(clear["Frag"]), vehicles, NO_TRUTH)
    sheet.write("track.missed", float(clear["CLR_FN"]), vehicles, NO_TRUTH)
    sheet.write("track.false", float(clear["CLR_FP"]), reported, "no track was reported in the graded range")
    _grade_heading(sheet, tracks)


def _switches_in_view(data: dict[str, Any], truth: pd.DataFrame, config: GradingConfig) -> int:
    """Count the switches that no occlusion excuses."""
    frames, actor_ids = data["frames"], data["actor_ids"]
    return sum(
        in_view(switch, truth, actor_ids[switch.vehicle], frames, config.hidden_fraction_max)
        for switch in switches(data, config.hit_iou_min)
    )


def _grade_heading(sheet: MetricSheet, tracks: pd.DataFrame) -> None:
    """Judge moving vehicles only: which end of a parked car is its front cannot be seen in its outline."""
    judged = tracks["judged"] & (tracks["true_mode"] != MODELS[0])
    error = tracks.loc[judged, "heading_error_deg"].abs().to_numpy()
    why = "no confirmed track followed a moving graded vehicle"
    sheet.mean("track.heading_abs_mean_deg", error, why)
    sheet.mean("track.heading_flip_rate", error > 90.0, why)

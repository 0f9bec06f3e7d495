"""Input of the tracking scores: graded vehicles, tracks and their overlaps per frame."""

from typing import TypedDict

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats, Ints


class TrackingSequence(TypedDict):
    """A run of V vehicles and T tracks with ids renumbered from 0.

    The keys are trackeval's, so that tests give the same sequence to its metric classes; it ignores the first two.
    """

    frames: Ints
    """(num_timesteps,) frame number of each time step."""
    actor_ids: Ints
    """(V,) actor id of each renumbered vehicle."""
    num_timesteps: int
    num_gt_ids: int
    """V."""
    num_tracker_ids: int
    """T."""
    num_gt_dets: int
    """Vehicles, summed over time steps."""
    num_tracker_dets: int
    """Tracks, summed over time steps."""
    gt_ids: list[Ints]
    """Renumbered vehicles (v,) of each time step."""
    tracker_ids: list[Ints]
    """Renumbered tracks (t,) of each time step."""
    similarity_scores: list[Floats]
    """Intersection over union (v, t) of each time step."""


def tracking_sequence(truth: pd.DataFrame, tracks: pd.DataFrame, overlaps: pd.DataFrame) -> TrackingSequence:
    """Collect the graded vehicles, the tracks on them, the false tracks, and all overlaps between these.

    Parameters
    ----------
    truth, tracks, overlaps
        Tables of a run, see `luxloop.scenarios.grading.frame_tables`.
    """
    vehicles = truth.loc[truth["graded"], ["frame", "actor_id"]]
    reported = tracks.loc[tracks["verdict"].isin(["graded", "false"]), ["frame", "track_id"]]
    actor_ids, track_ids = np.unique(vehicles["actor_id"]), np.unique(reported["track_id"])
    frames = np.unique(np.concatenate([truth["frame"], tracks["frame"]]))
    gt_ids = _ids_per_frame(vehicles, "actor_id", actor_ids, frames)
    tracker_ids = _ids_per_frame(reported, "track_id", track_ids, frames)
    return {
        "frames": frames,
        "actor_ids": actor_ids,
        "num_timesteps": len(frames),
        "num_gt_ids": len(actor_ids),
        "num_tracker_ids": len(track_ids),
        "num_gt_dets": len(vehicles),
        "num_tracker_dets": len(reported),
        "gt_ids": gt_ids,
        "tracker_ids": tracker_ids,
        "similarity_scores": _similarity_per_frame(overlaps, frames, gt_ids, tracker_ids, actor_ids, track_ids),
    }


def _ids_per_frame(rows: pd.DataFrame, column: str, ids: Ints, frames: Ints) -> list[Ints]:
    """Return the renumbered ids of each frame."""
    rows = rows.sort_values("frame", kind="stable")
    renumbered = np.searchsorted(ids, rows[column].to_numpy())
    per_frame = np.split(renumbered, np.searchsorted(rows["frame"].to_numpy(), frames[1:]))
    return per_frame[: len(frames)]  # without frames, np.split returns one empty array


def _similarity_per_frame(
    overlaps: pd.DataFrame,
    frames: Ints,
    gt_ids: list[Ints],
    tracker_ids: list[Ints],
    actor_ids: Ints,
    track_ids: Ints,
) -> list[Floats]:
    """Return the (v, t) overlaps of each frame."""
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
        tables.append(whole[np.ix_(gt_ids[t], tracker_ids[t])])
        whole[actor[t], track[t]] = 0.0
    return tables

"""Hits of CLEAR: tracks and vehicles of each frame, id switches, and rows of the tables that are hits."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, TypedDict

import numpy as np
import pandas as pd
import scipy

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.matching import CONTINUITY, NO_TRACK

COUNTED = ("graded", "false")
"""Verdicts of the tracks that CLEAR, HOTA, Identity and GOSPA count."""


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
    graded, counted = truth["graded"].to_numpy(np.bool_), tracks["verdict"].isin(COUNTED).to_numpy()
    vehicles, reported = truth["actor_id"].to_numpy()[graded], tracks["track_id"].to_numpy()[counted]
    actor_ids, track_ids = np.unique(vehicles), np.unique(reported)
    truth_frame, track_frame = truth["frame"].to_numpy(), tracks["frame"].to_numpy()
    frames = np.unique(np.concatenate([truth_frame, track_frame]))
    gt_ids = _ids_per_frame(truth_frame[graded], vehicles, actor_ids, frames)
    tracker_ids = _ids_per_frame(track_frame[counted], reported, track_ids, frames)
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


def _ids_per_frame(frame: Ints, number: Ints, ids: Ints, frames: Ints) -> list[Ints]:
    """Return the renumbered ids of each frame, from the frame and the id of each row (n,)."""
    order = np.argsort(frame, kind="stable")
    renumbered = np.searchsorted(ids, number[order])
    per_frame = np.split(renumbered, np.searchsorted(frame[order], frames[1:]))
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
    columns = [overlaps[name].to_numpy() for name in ("frame", "actor_id", "track_id", "iou")]
    known = np.flatnonzero(np.isin(columns[1], actor_ids) & np.isin(columns[2], track_ids))
    known = known[np.argsort(columns[0][known], kind="stable")]
    frame, actor_id, track_id, overlap = (column[known] for column in columns)
    bounds = np.searchsorted(frame, frames[1:])
    actor = np.split(np.searchsorted(actor_ids, actor_id), bounds)
    track = np.split(np.searchsorted(track_ids, track_id), bounds)
    iou = np.split(overlap, bounds)
    tables = []
    whole = np.zeros((len(actor_ids), len(track_ids)))
    for t in range(len(frames)):
        whole[actor[t], track[t]] = iou[t]
        tables.append(whole[np.ix_(gt_ids[t], tracker_ids[t])])
        whole[actor[t], track[t]] = 0.0
    return tables


ROUNDING = float(np.finfo(np.float64).eps)
"""Tolerance of comparisons of overlaps with limits, as in trackeval."""


HitStep = tuple[int, Ints, Ints]
"""Time step with its hits: vehicles (k,) and tracks (k,)."""


class IdSwitch(NamedTuple):
    """A vehicle is hit by another track than at its last hit."""

    vehicle: int
    """Renumbered id, as in the sequence."""
    before: int
    """Time step of the last hit by the old track."""
    step: int
    """Time step of the first hit by the new track."""


def clear_hits(sequence: TrackingSequence, hit_iou_min: float) -> Iterator[HitStep]:
    """Yield each time step with its hits: vehicles (k,) and tracks (k,), matched by CLEAR.

    The pairs of the previous step are kept first, the others follow by overlap (Bernardin and Stiefelhagen 2008,
    section 2.1.3).

    Parameters
    ----------
    sequence
        The run.
    hit_iou_min
        Least overlap of a hit.
    """
    matched_before = np.full(sequence["num_gt_ids"], NO_TRACK)
    steps = zip(sequence["gt_ids"], sequence["tracker_ids"], sequence["similarity_scores"], strict=True)
    for step, (vehicle, track, overlap) in enumerate(steps):
        if not overlap.size:  # as in trackeval, the previous pairs stay
            continue
        score = overlap + CONTINUITY * (track == matched_before[vehicle][:, None])
        score[overlap < hit_iou_min - ROUNDING] = 0.0
        row, column = scipy.optimize.linear_sum_assignment(score, maximize=True)
        hit = score[row, column] > ROUNDING
        vehicle, track = vehicle[row[hit]], track[column[hit]]
        matched_before[:] = NO_TRACK
        matched_before[vehicle] = track
        yield step, vehicle, track


def id_switches(vehicles: int, hits: Iterable[HitStep]) -> list[IdSwitch]:
    """Return every id switch of CLEAR, in the order of time steps.

    Parameters
    ----------
    vehicles
        Number of renumbered vehicles.
    hits
        From `clear_hits`.
    """
    found = []
    last_track = np.full(vehicles, NO_TRACK)
    last_step = np.zeros(vehicles, dtype=np.int64)
    for step, vehicle, track in hits:
        switched = (last_track[vehicle] != NO_TRACK) & (last_track[vehicle] != track)
        found += [IdSwitch(v, last_step[v], step) for v in vehicle[switched].tolist()]
        last_track[vehicle] = track
        last_step[vehicle] = step
    return found


def fragments(vehicles: int, hits: Iterable[HitStep]) -> Ints:
    """(V,) uninterrupted series of hits of each vehicle after its first.

    A vehicle that is not graded for a while (hidden, out of range) interrupts its series, too.

    Parameters
    ----------
    vehicles
        Number of renumbered vehicles.
    hits
        From `clear_hits`.
    """
    series = np.zeros(vehicles, dtype=np.int64)
    hit_before = np.zeros(vehicles, dtype=np.bool_)
    for _, vehicle, _ in hits:
        hit = np.zeros(vehicles, dtype=np.bool_)
        hit[vehicle] = True
        series += hit & ~hit_before
        hit_before = hit
    return np.maximum(series - 1, 0)


class ClearTable(NamedTuple):
    """Graded vehicles and counted tracks of a run, row by row, with their hits."""

    vehicles: pd.DataFrame
    """Graded rows of the truth table."""
    tracks: pd.DataFrame
    """Rows of the track table with a verdict of `COUNTED`."""
    is_hit: Bools
    """(len(vehicles),) mask of the vehicles that a track hits."""
    hits: Bools
    """(len(tracks),) mask of the tracks that hit a vehicle."""


def clear_table(
    truth: pd.DataFrame, tracks: pd.DataFrame, sequence: TrackingSequence, steps: Sequence[HitStep]
) -> ClearTable:
    """Return the rows of the tables `truth` and `tracks` that count, with the hits of `steps`, from `clear_hits`."""
    vehicles, counted = truth[truth["graded"]], tracks[tracks["verdict"].isin(COUNTED)]
    track_ids = np.unique(counted["track_id"])
    step = np.concatenate([[], *(np.full(len(vehicle), index) for index, vehicle, _ in steps)]).astype(np.int64)
    vehicle, track = (np.concatenate([[], *(hit[k] for hit in steps)]).astype(np.int64) for k in (1, 2))
    frames, actor_ids = sequence["frames"], sequence["actor_ids"]
    is_hit = np.isin(_cells(vehicles, "actor_id", frames, actor_ids), step * len(actor_ids) + vehicle)
    hits = np.isin(_cells(counted, "track_id", frames, track_ids), step * len(track_ids) + track)
    return ClearTable(vehicles, counted, is_hit, hits)


def hit_overlaps(clear: ClearTable, sequence: TrackingSequence, steps: Sequence[HitStep]) -> Floats:
    """(len(vehicles),) overlap of each graded vehicle with the track that hits it; NaN without a hit."""
    frames, actor_ids = sequence["frames"], sequence["actor_ids"]
    cell, overlap = [np.empty(0, np.int64)], [np.empty(0)]
    for step, vehicle, track in steps:
        row = _positions(sequence["gt_ids"][step], vehicle)
        column = _positions(sequence["tracker_ids"][step], track)
        cell.append(step * len(actor_ids) + vehicle)
        overlap.append(sequence["similarity_scores"][step][row, column])
    hit = np.concatenate(cell)
    found = np.full(len(clear.vehicles), np.nan)
    hits = _cells(clear.vehicles, "actor_id", frames, actor_ids)[clear.is_hit]
    found[clear.is_hit] = np.concatenate(overlap)[_positions(hit, hits)]
    return found


def _positions(values: Ints, wanted: Ints) -> Ints:
    """(k,) positions of some of the values (n,)."""
    order = np.argsort(values)
    return np.asarray(order[np.searchsorted(values[order], wanted)])


def _cells(rows: pd.DataFrame, column: str, frames: Ints, ids: Ints) -> Ints:
    """(n,) number of the cell of each row in a table of time steps and renumbered ids."""
    step, number = np.searchsorted(frames, rows["frame"]), np.searchsorted(ids, rows[column])
    return np.asarray(step * len(ids) + number)

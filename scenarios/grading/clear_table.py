"""Rows of the truth and track tables that are hits of CLEAR."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.id_switches import HitStep
from luxloop.scenarios.grading.tracking_sequence import TrackingSequence

COUNTED = ("graded", "false")
"""Verdicts of the tracks that CLEAR, HOTA, Identity and GOSPA count."""


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
    hits = _cells(clear.vehicles[clear.is_hit], "actor_id", frames, actor_ids)
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

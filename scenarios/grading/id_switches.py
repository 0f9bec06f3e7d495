"""Frame-by-frame matching of CLEAR, the id switches in it with their time steps, and the fragments of vehicles."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import scipy

from luxloop.scenarios.arrays import Ints
from luxloop.scenarios.grading.matching import CONTINUITY, NO_TRACK
from luxloop.scenarios.grading.tracking_sequence import TrackingSequence

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

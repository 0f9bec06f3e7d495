"""When ids are switched, which CLEAR counts but does not tell, and which switches nothing excuses."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment

from scenarios.arrays import Ints
from scenarios.grading.matching import CONTINUITY, NO_TRACK

ROUNDING = float(np.finfo(np.float64).eps)
"""By which trackeval lets an overlap miss the limit."""


class Switch(NamedTuple):
    """One vehicle is hit by another track than when it was last hit."""

    vehicle: int
    """Renumbered id, as in the sequence."""
    before: int
    """Time step at which the old track last hit it."""
    step: int
    """Time step at which the new one first does."""


def hits(sequence: dict[str, Any], hit_iou_min: float) -> Iterator[tuple[int, Ints, Ints]]:
    """Yield time step, vehicles (k,) and the tracks (k,) that hit them, matched as trackeval's CLEAR does.

    Bernardin and Stiefelhagen 2008, section 2.1.3: last step's pairs are kept first, the others are by overlap.

    Parameters
    ----------
    sequence
        As `track.sequence` gathers it for trackeval.
    hit_iou_min
        Overlap from which a track hits a vehicle.
    """
    matched_before = np.full(sequence["num_gt_ids"], NO_TRACK)
    for step in range(sequence["num_timesteps"]):
        vehicle, track, overlap = (sequence[name][step] for name in ("gt_ids", "tracker_ids", "similarity_scores"))
        if not overlap.size:  # trackeval forgets nothing in such a step
            continue
        score = overlap + CONTINUITY * (track == matched_before[vehicle][:, None])
        score[overlap < hit_iou_min - ROUNDING] = 0.0
        row, column = linear_sum_assignment(score, maximize=True)
        hit = score[row, column] > ROUNDING
        vehicle, track = vehicle[row[hit]], track[column[hit]]
        matched_before[:] = NO_TRACK
        matched_before[vehicle] = track
        yield step, vehicle, track


def switches(sequence: dict[str, Any], hit_iou_min: float) -> list[Switch]:
    """Every id switch of CLEAR, from the hits of a sequence."""
    found = []
    last_track = np.full(sequence["num_gt_ids"], NO_TRACK)
    last_step = np.zeros(sequence["num_gt_ids"], dtype=np.int64)
    for step, vehicle, track in hits(sequence, hit_iou_min):
        taken_over = (last_track[vehicle] != NO_TRACK) & (last_track[vehicle] != track)
        found += [Switch(v, last_step[v], step) for v in vehicle[taken_over].tolist()]
        last_track[vehicle] = track
        last_step[vehicle] = step
    return found


def in_view(switch: Switch, truth: pd.DataFrame, actor_id: int, frames: Any, hidden_fraction_max: float) -> bool:
    """Whether the vehicle was in view all the time from the old track's last hit to the new one's first.

    It was there in every one of these frames and never showed as little of itself as `hidden_fraction_max`, whatever
    hid it: something before it, or the blind spot of the rig.
    """
    first, last = frames[switch.before], frames[switch.step]
    between = truth[(truth["actor_id"] == actor_id) & truth["frame"].between(first, last)]
    seen = between["visible_fraction"] > hidden_fraction_max
    return len(between) == last - first + 1 and bool(seen.all())

"""Matching of vehicles with tracks by HOTA, CLEAR and Identity, and the summands of each vehicle.

Results show the totals (`score_sums.TrackingScores`). A comparison resamples vehicles and adds up their summands
(`scenarios.compare`). Tests compare the totals with those of trackeval 1.3.

References
----------
- HOTA: Luiten et al. 2021, HOTA: A higher order metric for evaluating multi-object tracking, IJCV 129.
- CLEAR: Bernardin and Stiefelhagen 2008, Evaluating multiple object tracking performance: The CLEAR MOT metrics.
- Identity: Ristani et al. 2016, Performance measures and a data set for multi-target, multi-camera tracking.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.id_switches import ROUNDING, HitStep, clear_hits, fragments, id_switches
from luxloop.scenarios.grading.tracking_sequence import TrackingSequence

ALPHAS = np.arange(0.05, 0.99, 0.05)
"""(19,) overlap thresholds of HOTA (Luiten et al. 2021, HOTA)."""


class HotaPairs(NamedTuple):
    """The M pairs that HOTA matches, sorted by vehicle and track, numbered as in the sequence."""

    vehicle: Ints
    """(M,)."""
    track: Ints
    """(M,)."""
    matches: Ints
    """(M, len(ALPHAS)) frames in which the pair is matched, by the largest of `ALPHAS` that its overlap reaches."""
    overlap: Floats
    """(len(ALPHAS),) sum of the overlaps of these frames."""


@dataclass(frozen=True, slots=True, eq=False)
class VehicleScores:
    """Summands of the scores for V vehicles and T tracks, numbered as in the sequence."""

    frames: Ints
    """(V,) frames in which the vehicle is graded."""
    hits: Ints
    """(V,) frames in which a track hits the vehicle (CLEAR)."""
    id_switches: Ints
    """(V,) id switches (CLEAR)."""
    fragments: Ints
    """(V,) uninterrupted series of hits after the first (CLEAR)."""
    identified: Ints
    """(V,) frames in which the vehicle is hit by the one track assigned to it for the whole run (Identity)."""
    pairs: HotaPairs
    track_frames: Ints
    """(T,) frames in which the track is reported."""

    @classmethod
    def of(
        cls, sequence: TrackingSequence, hit_iou_min: float, hits: Sequence[HitStep] | None = None
    ) -> "VehicleScores":
        """Match vehicles with tracks by the three rules.

        Parameters
        ----------
        sequence
            The run.
        hit_iou_min
            Least overlap of a hit of CLEAR and Identity.
        hits
            Result of `clear_hits`, if it is known already.
        """
        vehicles, tracks = sequence["num_gt_ids"], sequence["num_tracker_ids"]
        hits = list(clear_hits(sequence, hit_iou_min)) if hits is None else hits
        return cls(
            frames=_count(sequence["gt_ids"], vehicles),
            hits=_count([vehicle for _, vehicle, _ in hits], vehicles),
            id_switches=_count([[switch.vehicle for switch in id_switches(vehicles, hits)]], vehicles),
            fragments=fragments(vehicles, hits),
            identified=_identity_matches(sequence, hit_iou_min),
            pairs=_hota_pairs(sequence),
            track_frames=_count(sequence["tracker_ids"], tracks),
        )


def _count(ids: Sequence[Any], length: int) -> Ints:
    """(length,) occurrences of each id in several lists."""
    return np.bincount(np.concatenate([[], *ids]).astype(np.int64), minlength=length)


def _identity_matches(sequence: TrackingSequence, hit_iou_min: float) -> Ints:
    """(V,) hits under the assignment of whole tracks to vehicles with the most hits (Ristani et al. 2016)."""
    together = np.zeros((sequence["num_gt_ids"], sequence["num_tracker_ids"]), dtype=np.int64)
    for vehicle, track, overlap in _steps(sequence):
        together[np.ix_(vehicle, track)] += overlap >= hit_iou_min
    row, column = scipy.optimize.linear_sum_assignment(together, maximize=True)
    out = np.zeros(len(together), dtype=np.int64)
    out[row] = together[row, column]
    return out


def _hota_pairs(sequence: TrackingSequence) -> HotaPairs:
    """Match each frame, preferring pairs that agree over the whole run (Luiten et al. 2021, section 5)."""
    alignment = _alignment(sequence)
    pairs, overlaps = [np.empty(0, np.int64)], [np.empty(0)]
    for vehicle, track, overlap in _steps(sequence):
        row, column = scipy.optimize.linear_sum_assignment(alignment[np.ix_(vehicle, track)] * overlap, maximize=True)
        pairs.append(vehicle[row] * sequence["num_tracker_ids"] + track[column])
        overlaps.append(overlap[row, column])
    pair, overlap = np.concatenate(pairs), np.concatenate(overlaps)
    reached = np.searchsorted(ALPHAS - ROUNDING, overlap, side="right") - 1
    pair, overlap, reached = pair[reached >= 0], overlap[reached >= 0], reached[reached >= 0]
    names, row = np.unique(pair, return_inverse=True)
    matches = np.zeros((len(names), len(ALPHAS)), dtype=np.int64)
    np.add.at(matches, (row, reached), 1)
    vehicle, track = np.divmod(names, max(sequence["num_tracker_ids"], 1))
    sums = np.zeros(len(ALPHAS))
    np.add.at(sums, reached, overlap)
    return HotaPairs(vehicle, track, matches, sums)


def _alignment(sequence: TrackingSequence) -> Floats:
    """(V, T) share of their frames that a vehicle and a track have in common, weighted by overlap."""
    common = np.zeros((sequence["num_gt_ids"], sequence["num_tracker_ids"]))
    for vehicle, track, overlap in _steps(sequence):
        either = overlap.sum(axis=0) + overlap.sum(axis=1)[:, None] - overlap
        common[np.ix_(vehicle, track)] += np.divide(overlap, either, np.zeros_like(overlap), where=either > ROUNDING)
    vehicle_frames = _count(sequence["gt_ids"], len(common))
    track_frames = _count(sequence["tracker_ids"], common.shape[1])
    alignment: Floats = common / (vehicle_frames[:, None] + track_frames - common)
    return alignment


def _steps(sequence: TrackingSequence) -> list[tuple[Ints, Ints, Floats]]:
    """Return vehicles (v,), tracks (t,) and overlaps (v, t) of every time step that has both."""
    steps = zip(sequence["gt_ids"], sequence["tracker_ids"], sequence["similarity_scores"], strict=True)
    return [(vehicle, track, overlap) for vehicle, track, overlap in steps if overlap.size]

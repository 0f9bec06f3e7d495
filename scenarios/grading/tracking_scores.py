"""HOTA, CLEAR and identity scores of a run: totals by trackeval, and the summands of each vehicle.

Results show the totals. A comparison resamples vehicles and adds up their summands (`scenarios.compare`). Tests check
that the summands add up to trackeval's counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.id_switches import ROUNDING, HitStep, clear_hits, id_switches
from luxloop.scenarios.grading.tracking_sequence import TrackingSequence

ALPHAS = np.arange(0.05, 0.99, 0.05)
"""(19,) overlap thresholds of HOTA (Luiten et al. 2021, HOTA)."""


@dataclass(frozen=True, slots=True)
class TrackingScores:
    """Totals of one run."""

    hota: float
    """Mean over `ALPHAS`, as the next three."""
    deta: float
    assa: float
    loca: float
    most_matches: int
    """HOTA's true positives at the threshold with most of them; without any, `loca` has no meaning."""
    mota: float
    id_switches: int
    fragments: int
    missed: int
    false: int
    idf1: float

    @classmethod
    def of(cls, sequence: TrackingSequence, hit_iou_min: float) -> "TrackingScores":
        """Evaluate a run with trackeval's metric classes.

        trackeval also counts a fragment where a vehicle stops being graded (hidden, out of range) and returns: every
        uninterrupted series of hits after the first counts.

        Parameters
        ----------
        sequence
            The run.
        hit_iou_min
            Least overlap of a hit of CLEAR and Identity.
        """
        from trackeval.metrics import CLEAR, HOTA, Identity  # slow to import

        limits = {"THRESHOLD": hit_iou_min, "PRINT_CONFIG": False}
        hota = HOTA().eval_sequence(sequence)
        clear = CLEAR(dict(limits)).eval_sequence(sequence)
        identity = Identity(dict(limits)).eval_sequence(sequence)
        return cls(
            hota=float(np.mean(hota["HOTA"])),
            deta=float(np.mean(hota["DetA"])),
            assa=float(np.mean(hota["AssA"])),
            loca=float(np.mean(hota["LocA"])),
            most_matches=int(hota["HOTA_TP"].max()),
            mota=float(clear["MOTA"]),
            id_switches=int(clear["IDSW"]),
            fragments=int(clear["Frag"]),
            missed=int(clear["CLR_FN"]),
            false=int(clear["CLR_FP"]),
            idf1=float(identity["IDF1"]),
        )


@dataclass(frozen=True, slots=True, eq=False)
class VehicleScores:
    """Summands of the scores for V vehicles and T tracks, numbered as in the sequence."""

    hits: Ints
    """(V,) frames in which a track hits the vehicle (CLEAR)."""
    id_switches: Ints
    """(V,) id switches (CLEAR)."""
    identified: Ints
    """(V,) frames in which the vehicle is hit by the one track assigned to it for the whole run (Identity)."""
    hota_matches: Ints
    """(V, T, len(ALPHAS) + 1) frames in which HOTA matches them, by how many of `ALPHAS` their overlap reaches."""
    track_frames: Ints
    """(T,) frames in which the track is reported."""

    @classmethod
    def of(
        cls, sequence: TrackingSequence, hit_iou_min: float, hits: Sequence[HitStep] | None = None
    ) -> "VehicleScores":
        """Match vehicles with tracks by the three matching rules of trackeval.

        Parameters
        ----------
        sequence, hit_iou_min
            As for `TrackingScores.of`.
        hits
            Result of `clear_hits`, if it is known already.
        """
        vehicles, tracks = sequence["num_gt_ids"], sequence["num_tracker_ids"]
        hits = list(clear_hits(sequence, hit_iou_min)) if hits is None else hits
        hit = [vehicle for _, vehicle, _ in hits]
        switched = [switch.vehicle for switch in id_switches(vehicles, hits)]
        return cls(
            hits=_count(np.concatenate(hit) if hit else [], vehicles),
            id_switches=_count(switched, vehicles),
            identified=_identity_matches(sequence, hit_iou_min),
            hota_matches=_hota_matches(sequence),
            track_frames=_count(np.concatenate([[], *sequence["tracker_ids"]]), tracks),
        )


def _count(ids: Any, length: int) -> Ints:
    return np.bincount(np.asarray(ids, dtype=np.int64), minlength=length)


def _identity_matches(sequence: TrackingSequence, hit_iou_min: float) -> Ints:
    """(V,) hits under the assignment of whole tracks to vehicles with the most hits (Ristani et al. 2016)."""
    together = np.zeros((sequence["num_gt_ids"], sequence["num_tracker_ids"]), dtype=np.int64)
    for vehicle, track, overlap in _steps(sequence):
        together[np.ix_(vehicle, track)] += overlap >= hit_iou_min
    row, column = scipy.optimize.linear_sum_assignment(together, maximize=True)
    out = np.zeros(len(together), dtype=np.int64)
    out[row] = together[row, column]
    return out


def _hota_matches(sequence: TrackingSequence) -> Ints:
    """Match each frame, preferring pairs that agree over the whole run (Luiten et al. 2021)."""
    alignment = _alignment(sequence)
    out = np.zeros((*alignment.shape, len(ALPHAS) + 1), dtype=np.int64)
    for vehicle, track, overlap in _steps(sequence):
        row, column = scipy.optimize.linear_sum_assignment(alignment[np.ix_(vehicle, track)] * overlap, maximize=True)
        reached = np.searchsorted(ALPHAS - ROUNDING, overlap[row, column], side="right")
        out[vehicle[row], track[column], reached] += 1
    return out


def _alignment(sequence: TrackingSequence) -> Floats:
    """(V, T) share of their frames that a vehicle and a track have in common, weighted by overlap."""
    common = np.zeros((sequence["num_gt_ids"], sequence["num_tracker_ids"]))
    for vehicle, track, overlap in _steps(sequence):
        either = overlap.sum(axis=0) + overlap.sum(axis=1)[:, None] - overlap
        common[np.ix_(vehicle, track)] += np.divide(overlap, either, np.zeros_like(overlap), where=either > ROUNDING)
    vehicle_frames = _count(np.concatenate([[], *sequence["gt_ids"]]), len(common))
    track_frames = _count(np.concatenate([[], *sequence["tracker_ids"]]), common.shape[1])
    alignment: Floats = common / (vehicle_frames[:, None] + track_frames - common)
    return alignment


def _steps(sequence: TrackingSequence) -> list[tuple[Ints, Ints, Floats]]:
    """Return vehicles (v,), tracks (t,) and overlaps (v, t) of every time step that has both."""
    steps = zip(sequence["gt_ids"], sequence["tracker_ids"], sequence["similarity_scores"], strict=True)
    return [(vehicle, track, overlap) for vehicle, track, overlap in steps if overlap.size]

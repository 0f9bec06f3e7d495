"""HOTA, CLEAR and Identity vehicle by vehicle: the summands of which trackeval reports the totals."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from scenarios.arrays import Floats, Ints
from scenarios.grading.switches import ROUNDING, hits, switches

ALPHAS = np.arange(0.05, 0.99, 0.05)
"""Overlaps at which HOTA asks for a match, 19 of them (Luiten et al. 2021, HOTA)."""


@dataclass(frozen=True, slots=True, eq=False)
class Matching:
    """Who was matched with whom, of V vehicles and T tracks that are numbered as in the sequence."""

    hits: Ints
    """(V,) frames in which a track hits the vehicle (CLEAR)."""
    switches: Ints
    """(V,) id switches (CLEAR)."""
    identified: Ints
    """(V,) frames in which the one track hits it that stands for it over the whole run (Identity)."""
    overlaps: Ints
    """(V, T, len(ALPHAS) + 1) frames in which HOTA matches them, by how many of `ALPHAS` their overlap reaches."""
    track_frames: Ints
    """(T,) frames in which the track is reported."""


def match(sequence: dict[str, Any], hit_iou_min: float) -> Matching:
    """Match vehicles with tracks, each time as trackeval does.

    Parameters
    ----------
    sequence
        As `scenarios.grading.track_metrics.sequence` gathers it for trackeval.
    hit_iou_min
        Overlap from which CLEAR and Identity count a hit.
    """
    vehicles, tracks = sequence["num_gt_ids"], sequence["num_tracker_ids"]
    hit = [vehicle for _, vehicle, _ in hits(sequence, hit_iou_min)]
    switched = [switch.vehicle for switch in switches(sequence, hit_iou_min)]
    return Matching(
        hits=_count(np.concatenate(hit) if hit else [], vehicles),
        switches=_count(switched, vehicles),
        identified=_identified(sequence, hit_iou_min),
        overlaps=_hota_matches(sequence),
        track_frames=_count(np.concatenate([[], *sequence["tracker_ids"]]), tracks),
    )


def _count(ids: Any, length: int) -> Ints:
    return np.bincount(np.asarray(ids, dtype=np.int64), minlength=length)


def _identified(sequence: dict[str, Any], hit_iou_min: float) -> Ints:
    """Pair whole tracks with vehicles, as many hits as there can be (Ristani et al. 2016)."""
    together = np.zeros((sequence["num_gt_ids"], sequence["num_tracker_ids"]), dtype=np.int64)
    for vehicle, track, overlap in _steps(sequence):
        together[np.ix_(vehicle, track)] += overlap >= hit_iou_min
    row, column = linear_sum_assignment(together, maximize=True)
    out = np.zeros(len(together), dtype=np.int64)
    out[row] = together[row, column]
    return out


def _hota_matches(sequence: dict[str, Any]) -> Ints:
    """Match frame by frame, those first that agree over the whole run (Luiten et al. 2021)."""
    alignment = _alignment(sequence)
    out = np.zeros((*alignment.shape, len(ALPHAS) + 1), dtype=np.int64)
    for vehicle, track, overlap in _steps(sequence):
        row, column = linear_sum_assignment(alignment[np.ix_(vehicle, track)] * overlap, maximize=True)
        reached = np.searchsorted(ALPHAS - ROUNDING, overlap[row, column], side="right")
        out[vehicle[row], track[column], reached] += 1
    return out


def _alignment(sequence: dict[str, Any]) -> Floats:
    """(V, T) share of their frames that a vehicle and a track have in common, weighted by overlap."""
    common = np.zeros((sequence["num_gt_ids"], sequence["num_tracker_ids"]))
    for vehicle, track, overlap in _steps(sequence):
        either = overlap.sum(axis=0) + overlap.sum(axis=1)[:, None] - overlap
        common[np.ix_(vehicle, track)] += np.divide(overlap, either, np.zeros_like(overlap), where=either > ROUNDING)
    vehicle_frames = _count(np.concatenate([[], *sequence["gt_ids"]]), len(common))
    track_frames = _count(np.concatenate([[], *sequence["tracker_ids"]]), common.shape[1])
    alignment: Floats = common / (vehicle_frames[:, None] + track_frames - common)
    return alignment


def _steps(sequence: dict[str, Any]) -> list[tuple[Ints, Ints, Floats]]:
    """Vehicles, tracks and their overlaps in every step that has both."""
    steps = zip(sequence["gt_ids"], sequence["tracker_ids"], sequence["similarity_scores"], strict=True)
    return [(vehicle, track, overlap) for vehicle, track, overlap in steps if overlap.size]

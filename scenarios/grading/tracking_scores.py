"""Matching of vehicles with tracks by HOTA, CLEAR and Identity, and the summands of each vehicle.

Results show the totals (`TrackingScores`). A comparison resamples vehicles and adds up their summands
(`scenarios.compare`). Tests compare the totals with those of trackeval 1.3.

References
----------
- HOTA: Luiten et al. 2021, HOTA: A higher order metric for evaluating multi-object tracking, IJCV 129.
- CLEAR: Bernardin and Stiefelhagen 2008, Evaluating multiple object tracking performance: The CLEAR MOT metrics.
- Identity: Ristani et al. 2016, Performance measures and a data set for multi-target, multi-camera tracking.

The scores of any set of vehicles follow from their sums, so that vehicles can be left out without another matching.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.grading.clear_table import (
    ROUNDING,
    HitStep,
    TrackingSequence,
    clear_hits,
    fragments,
    id_switches,
)
from luxloop.scenarios.metrics.definitions import DEFINITIONS
from luxloop.scenarios.statistics.intervals import NO_ERROR, TOO_FEW, Interval
from luxloop.scenarios.statistics.jackknife import jackknife_interval

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


SCORES = ("hota", "mota", "idf1")
"""Scores with an interval."""


def reached(counts: Ints) -> Ints:
    """(M, len(ALPHAS)) matches at each threshold, from counts (M, len(ALPHAS)) by the largest threshold reached.

    An overlap reaches all smaller thresholds as well.
    """
    return np.asarray(counts[:, ::-1].cumsum(axis=1)[:, ::-1])


def hota_sums(row: Ints, frames: Ints | Floats, counts: Ints, length: int) -> Floats:
    """(length, 2 len(ALPHAS)) true positives of each unit, and sums of their association scores.

    A pair matched in c frames adds c, and c * c / (frames of either) (Luiten et al. 2021, section 5.3).

    Parameters
    ----------
    row
        (M,) unit of each pair.
    frames
        (M,) frames of its vehicle and of its track, added.
    counts
        (M, len(ALPHAS)) frames in which they match, by the largest threshold reached.
    length
        Number of units.
    """
    matched = reached(counts)
    out = np.zeros((length, 2 * len(ALPHAS)))
    np.add.at(out, row, np.hstack([matched, matched**2 / (frames[:, None] - matched)]))
    return out


def hota(detections: Floats, matched: Floats, associated: Floats) -> Floats:
    """(R,) geometric mean of detection and association accuracy, averaged over thresholds (Luiten et al. 2021).

    Runs are pooled as trackeval combines sequences.

    Parameters
    ----------
    detections
        (R,) graded vehicles and reported tracks, summed over frames.
    matched, associated
        (R, len(ALPHAS)) true positives, and sums of their association scores.
    """
    # DetA = TP / (TP + FN + FP), AssA = sum of A / TP: TP cancels in their product.
    pooled: Floats = np.sqrt(associated / np.maximum(detections[:, None] - matched, 1.0)).mean(axis=1)
    return pooled


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
    """Uninterrupted series of hits of a vehicle after its first, also if it was hidden or out of range in between."""
    missed: int
    false: int
    idf1: float

    @classmethod
    def of(cls, scores: VehicleScores) -> "TrackingScores":
        """Add up the summands of all vehicles."""
        vehicles, tracks = int(scores.frames.sum()), int(scores.track_frames.sum())
        hits, switches = int(scores.hits.sum()), int(scores.id_switches.sum())
        matched, associated = np.split(_vehicle_hota_sums(scores).sum(axis=0), 2)
        overlap = scores.pairs.overlap[::-1].cumsum()[::-1]
        return cls(
            hota=float(hota(np.array([vehicles + tracks]), matched[None], associated[None])[0]),
            deta=float(np.mean(matched / np.maximum(vehicles + tracks - matched, 1.0))),
            assa=float(np.mean(associated / np.maximum(matched, 1.0))),
            loca=float(np.mean(np.divide(overlap, matched, np.ones_like(overlap), where=matched > 0.0))),
            most_matches=int(matched.max()),
            mota=(2 * hits - tracks - switches) / vehicles if vehicles else 0.0,
            id_switches=switches,
            fragments=int(scores.fragments.sum()),
            missed=vehicles - hits,
            false=tracks - hits,
            idf1=2.0 * float(scores.identified.sum()) / max(vehicles + tracks, 1),
        )


def intervals(sequence: TrackingSequence, scores: VehicleScores, reported: Ints) -> dict[str, Interval]:
    """Return the 95 % intervals of HOTA, MOTA and IDF1; none for too few vehicles.

    The tracks on no graded vehicle are one more cluster, as in a comparison of runs.

    Parameters
    ----------
    scores
        Summands of the sequence.
    reported
        Actor id of each counted track in each frame, other ids for tracks on no graded vehicle.
    """
    sums = _cluster_sums(sequence, scores, reported)
    sums = sums[sums[:, :2].any(axis=1)]
    total = sums.sum(axis=0)
    if not total[1]:
        return {}
    value, without = _scores(total[None]), _scores(total - sums)
    weight = sums[:, 0] + sums[:, 1]
    found = {
        name: jackknife_interval(float(value[name][0]), without[name], weight, DEFINITIONS[name].range)
        for name in value
    }
    return {name: interval for name, interval in found.items() if interval is not None}


def why_no_interval(name: str, value: float) -> str:
    """Return the reason if a score of `intervals` is not among them; empty for other scores, which never have one."""
    if name not in SCORES:
        return ""
    return NO_ERROR if name == "mota" and value == 1.0 else TOO_FEW


def _cluster_sums(sequence: TrackingSequence, scores: VehicleScores, reported: Ints) -> Floats:
    """(V + 1, 5 + 2 len(ALPHAS)) tracks, observations, hits, id switches, identified frames, and the sums of HOTA.

    The first row holds the tracks on no graded vehicle.
    """
    actor_ids = sequence["actor_ids"]
    unit = np.where(np.isin(reported, actor_ids), np.searchsorted(actor_ids, reported) + 1, 0)
    counts = np.column_stack([scores.frames, scores.hits, scores.id_switches, scores.identified])
    sums = np.hstack([counts, _vehicle_hota_sums(scores)])
    sums = np.vstack([np.zeros(sums.shape[1]), sums])
    return np.column_stack([np.bincount(unit, minlength=len(sums)), sums])


def _scores(sums: Floats) -> dict[str, Floats]:
    """Return HOTA, MOTA and IDF1 (R,) of sums (R, 5 + 2 len(ALPHAS)); NaN without a vehicle."""
    tracks, vehicles, hits, switches, identified = sums[:, :5].T
    matched, associated = np.split(sums[:, 5:], 2, axis=1)
    seen = np.where(vehicles > 0.0, vehicles, np.nan)
    return {
        "track.hota": hota(vehicles + tracks, matched, associated) + 0.0 * seen,
        "track.mota": (2.0 * hits - tracks - switches) / seen,
        "track.idf1": 2.0 * identified / (seen + tracks),
    }


def _vehicle_hota_sums(scores: VehicleScores) -> Floats:
    """(V, 2 len(ALPHAS)) true positives of each vehicle, and sums of their association scores."""
    pairs = scores.pairs
    frames = scores.frames[pairs.vehicle] + scores.track_frames[pairs.track]
    return hota_sums(pairs.vehicle, frames, pairs.matches, len(scores.frames))

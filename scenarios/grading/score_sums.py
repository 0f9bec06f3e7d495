"""HOTA, CLEAR and Identity from sums per vehicle, and their intervals.

The scores of any set of vehicles follow from their sums, so that vehicles can be left out without another matching.
"""

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.metric_range import possible_range
from luxloop.scenarios.grading.tracking_scores import ALPHAS, VehicleScores
from luxloop.scenarios.grading.tracking_sequence import TrackingSequence
from luxloop.scenarios.statistics.confidence import NO_ERROR, TOO_FEW, Interval
from luxloop.scenarios.statistics.jackknife import jackknife_interval

SCORES = ("hota", "mota", "idf1")
"""Scores with an interval."""


def reached(counts: Ints) -> Ints:
    """(M, len(ALPHAS)) matches at each threshold, from counts (M, len(ALPHAS)) by the largest threshold reached.

    An overlap reaches all smaller thresholds as well.
    """
    return np.asarray(counts[:, ::-1].cumsum(axis=1)[:, ::-1])


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
        name: jackknife_interval(float(value[name][0]), without[name], weight, possible_range(name, "1"))
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
    observations = np.bincount(np.concatenate([[], *sequence["gt_ids"]]).astype(np.int64), minlength=len(actor_ids))
    counts = np.column_stack([observations, scores.hits, scores.id_switches, scores.identified])
    sums = np.hstack([np.vstack([np.zeros(counts.shape[1]), counts]), _hota_sums(observations, scores)])
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


def _hota_sums(observations: Ints, scores: VehicleScores) -> Floats:
    """(V + 1, 2 len(ALPHAS)) true positives and association scores of each unit; the first unit has none."""
    vehicle, track = np.nonzero(scores.hota_matches[:, :, 1:].any(axis=2))
    matched = reached(scores.hota_matches[vehicle, track, 1:])
    either = observations[vehicle, None] + scores.track_frames[track, None] - matched
    out = np.zeros((len(observations) + 1, 2 * len(ALPHAS)))
    np.add.at(out, vehicle + 1, np.hstack([matched, matched**2 / either]))
    return out

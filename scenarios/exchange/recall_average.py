"""AMOTA and AMOTP of nuScenes: MOTA and MOTP averaged over thresholds of the score.

For each of 40 recalls r from 0.1 to 1, tracks below the score at which r is reached are left out, and

    MOTAR = max(0, 1 - (IDS + FP + FN - (1 - r) P) / (r P)),    AMOTA = mean MOTAR,    AMOTP = mean MOTP,

with P true boxes (Caesar et al. 2020, nuScenes, section 3.2; README of its tracking evaluation; Weng and Kitani 2019).
The arithmetic is that of the development kit (`nuscenes.eval.tracking`: `TrackingEvaluation`, `TrackingEval`, `motar`):
the score of a track is the mean of its boxes; in MOTAR, r is the measured recall, in which matches with an id switch do
not count; a recall that is not reached counts as 0 in AMOTA and as 2 m in AMOTP. Its range limits and its interpolation
over gaps are preprocessing of the data set and not done here.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.exchange.distance_matching import (
    NOT_MATCHED,
    DistanceCounts,
    DistanceStep,
    count,
    match_frames,
)

RECALLS = np.linspace(0.1, 1.0, 40).round(12)
"""(40,) recalls of the average."""
WORST_MOTP_M = 2.0
"""MOTP of a recall that is not reached [m]."""


class RecallPoint(NamedTuple):
    """Counts at one recall."""

    recall: float
    threshold: float
    """Least score of the tracks that count; NaN if the recall is not reached."""
    counts: DistanceCounts | None

    @property
    def motar(self) -> float:
        """MOTA normalised by the recall; 0 if the recall is not reached."""
        if self.counts is None or not self.counts.matches:
            return 0.0
        objects = self.counts.objects
        reached = self.counts.matches / objects
        errors = self.counts.misses + self.counts.switches + self.counts.false - (1.0 - reached) * objects
        return max(0.0, 1.0 - errors / (reached * objects))

    @property
    def motp_m(self) -> float:
        """Mean distance of the pairs [m]."""
        found = float("nan") if self.counts is None else self.counts.motp_m
        return WORST_MOTP_M if np.isnan(found) else found


class RecallAverage(NamedTuple):
    """Averages over all recalls."""

    amota: float
    amotp_m: float


def recall_curve(steps: Sequence[DistanceStep], scores: Sequence[Floats], distance_max_m: float) -> list[RecallPoint]:
    """Return the counts at every recall, for at least one true box.

    Parameters
    ----------
    steps
        All frames.
    scores
        Scores (k,) of the tracks of each frame: of a whole track, the same in all frames.
    distance_max_m
        Distance of the centres from which a pair does not match [m].
    """
    objects = sum(len(step.truth_id) for step in steps)
    thresholds = _thresholds(_matched_scores(steps, scores, distance_max_m), objects)
    counted: dict[float, DistanceCounts] = {}
    points = []
    for recall, threshold in zip(RECALLS.tolist(), thresholds.tolist(), strict=True):
        if not np.isnan(threshold) and threshold not in counted:
            surer = [_above(step, score, threshold) for step, score in zip(steps, scores, strict=True)]
            counted[threshold] = count(surer, match_frames(surer, distance_max_m))
        points.append(RecallPoint(recall, threshold, counted.get(threshold)))
    return points


def average(points: Sequence[RecallPoint]) -> RecallAverage:
    """Return the averages of a curve."""
    return RecallAverage(
        float(np.mean([point.motar for point in points])), float(np.mean([point.motp_m for point in points]))
    )


def track_scores(track_id: Ints, score: Floats) -> Floats:
    """(N,) mean score of the track of each box, from ids (N,) and scores (N,) of the boxes."""
    if not len(track_id):
        return score
    boxes = np.bincount(track_id)
    found: Floats = (np.bincount(track_id, score) / np.maximum(boxes, 1))[track_id]
    return found


def _matched_scores(steps: Sequence[DistanceStep], scores: Sequence[Floats], distance_max_m: float) -> Floats:
    """Return the scores of all matches without an id switch, over all tracks."""
    found = [np.empty(0)]
    for match, score in zip(match_frames(steps, distance_max_m), scores, strict=True):
        found.append(score[match.track[(match.track != NOT_MATCHED) & ~match.switched]])
    return np.concatenate(found)


def _thresholds(scores: Floats, objects: int) -> Floats:
    """(40,) score at which each recall is reached; NaN for those beyond the last match."""
    if not len(scores):
        return np.full(len(RECALLS), np.nan)
    recall = np.arange(1, len(scores) + 1) / objects
    found: Floats = np.interp(RECALLS, recall, np.sort(scores)[::-1], right=0.0)
    found[recall.max() < RECALLS] = np.nan
    return found


def _above(step: DistanceStep, score: Floats, threshold: float) -> DistanceStep:
    kept = score >= threshold
    return DistanceStep(step.truth_id, step.track_id[kept], step.distance[:, kept])

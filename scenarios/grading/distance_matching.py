"""Matching by distance and averages over recalls, as in the tracking task of nuScenes.

nuScenes counts with py-motmetrics (Heindl 2017; Bernardin and Stiefelhagen 2008, CLEAR): an object keeps the track of
its last match, also after a gap, while they are closer than the limit. The others are assigned with as many pairs as
possible and then the least sum of distances. A pair with another track than at the last match is an id switch.

AMOTA and AMOTP are MOTA and MOTP averaged over thresholds of the score. For each of 40 recalls r from 0.1 to 1, tracks
below the score at which r is reached are left out, and

    MOTAR = max(0, 1 - (IDS + FP + FN - (1 - r) P) / (r P)),    AMOTA = mean MOTAR,    AMOTP = mean MOTP,

with P true boxes (Caesar et al. 2020, nuScenes, section 3.2; README of its tracking evaluation; Weng and Kitani 2019).
The arithmetic is that of the development kit (`nuscenes.eval.tracking`: `TrackingEvaluation`, `TrackingEval`, `motar`):
the score of a track is the mean of its boxes; in MOTAR, r is the measured recall, in which matches with an id switch do
not count; a recall that is not reached counts as 0 in AMOTA and as 2 m in AMOTP. Its range limits and its interpolation
over gaps are preprocessing of the data set and not done here.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.clear_table import ClearTable
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.metrics.definitions import NO_VEHICLE
from luxloop.scenarios.result import NOT_REPORTED

NO_SCORE = f"{NOT_REPORTED} scores of its tracks"
POSITION = ["x_world_m", "y_world_m"]
NOT_MATCHED = -1


class DistanceStep(NamedTuple):
    """Objects and tracks of one frame."""

    truth_id: Ints
    """(t,) ids of the objects, from 0."""
    track_id: Ints
    """(k,) ids of the tracks."""
    distance: Floats
    """(t, k) distances of the centres [m]; NaN for pairs that cannot match."""


class DistanceMatch(NamedTuple):
    """Matching of one frame."""

    track: Ints
    """(t,) place of the matched track in the frame; `NOT_MATCHED` for a missed object."""
    switched: Bools
    """(t,) True for an id switch."""


class DistanceCounts(NamedTuple):
    """Counts of CLEAR over all frames."""

    objects: int
    matches: int
    """Pairs without id switches, as py-motmetrics counts them."""
    switches: int
    misses: int
    false: int
    fragments: int
    distance_m: float
    """Sum of the distances of all pairs [m]."""

    @property
    def mota(self) -> float:
        """Multiple object tracking accuracy of at least one object."""
        return 1.0 - (self.misses + self.switches + self.false) / self.objects

    @property
    def motp_m(self) -> float:
        """Mean distance of the pairs [m]; NaN without any."""
        pairs = self.matches + self.switches
        return self.distance_m / pairs if pairs else float("nan")


def grade(sheet: MetricSheet, clear: ClearTable, distance_max_m: float, filters: Mapping[str, str]) -> None:
    """Enter AMOTA and AMOTP, as means over the classes of the vehicles.

    Parameters
    ----------
    clear
        Graded vehicles, and counted tracks with their `score` and class (`kind`).
    distance_max_m
        `GradingConfig.match_distance_m`.
    filters
        The classes to grade, if there is a filter.
    """
    vehicles, tracks = clear.vehicles, clear.tracks
    found: list[RecallAverage] = []
    scored = "score" in tracks and bool(tracks["score"].notna().all())
    if scored:
        score = track_scores(tracks["track_id"].to_numpy(), tracks["score"].to_numpy(np.float64))
        for here, there in _by_class(vehicles, tracks, filters.get("class", "")):
            steps, scores = _steps(vehicles[here], tracks[there], score[there])
            found.append(average(recall_curve(steps, scores, distance_max_m)))
    means = np.mean(found, axis=0).tolist() if found else [None, None]
    for name, value in zip(("amota", "amotp_m"), means, strict=True):
        sheet.write(f"track.{name}", value, len(vehicles), NO_VEHICLE if scored else NO_SCORE)


def _by_class(vehicles: pd.DataFrame, tracks: pd.DataFrame, chosen: str) -> Iterator[tuple[Bools, Bools]]:
    """Yield masks of the vehicles and tracks of each class, of all of them if one side has no classes."""
    kind, label = (rows["kind"].to_numpy(np.str_) for rows in (vehicles, tracks))
    if not (kind != "").any() or not (label != "").any():
        if len(kind):
            yield np.ones(len(kind), np.bool_), np.ones(len(label), np.bool_)
        return
    for name in np.unique(kind):
        if not chosen or name in chosen.split("|"):
            yield kind == name, label == name


def _steps(vehicles: pd.DataFrame, tracks: pd.DataFrame, score: Floats) -> tuple[list[DistanceStep], list[Floats]]:
    """Return the distances of each frame, and the scores of its tracks."""
    vehicles = vehicles.sort_values("frame", kind="stable")
    tracks = tracks.assign(score=score).sort_values("frame", kind="stable")
    vehicle, track = (rows[POSITION].to_numpy(np.float64) for rows in (vehicles, tracks))
    actor_id, track_id = vehicles["actor_id"].to_numpy(), tracks["track_id"].to_numpy()
    frames = np.unique(np.concatenate([vehicles["frame"], tracks["frame"]]))
    row, column = (np.searchsorted(rows["frame"], [*frames, np.inf]) for rows in (vehicles, tracks))
    steps, scores = [], []
    for k in range(len(frames)):
        a, b = slice(row[k], row[k + 1]), slice(column[k], column[k + 1])
        apart = vehicle[a, None] - track[None, b]
        steps.append(DistanceStep(actor_id[a], track_id[b], np.hypot(apart[..., 0], apart[..., 1])))
        scores.append(tracks["score"].to_numpy(np.float64)[b])
    return steps, scores


def match_frames(steps: Iterable[DistanceStep], distance_max_m: float) -> Iterator[DistanceMatch]:
    """Match frame by frame; a pair is closer than `distance_max_m`."""
    last: dict[int, int] = {}
    for step in steps:
        feasible = step.distance < distance_max_m  # False for NaN
        track = _kept(step, feasible, last)
        _assign(step, feasible, track)
        pair = np.flatnonzero(track != NOT_MATCHED)
        now = dict(zip(step.truth_id[pair].tolist(), step.track_id[track[pair]].tolist(), strict=True))
        switched = np.zeros(len(track), np.bool_)
        switched[pair] = [last.get(truth, track) != track for truth, track in now.items()]
        last |= now
        yield DistanceMatch(track, switched)


def count(steps: Iterable[DistanceStep], matches: Iterable[DistanceMatch]) -> DistanceCounts:
    """Return the counts of all frames and their matches."""
    objects = pairs = switches = tracks = 0
    distance_m = 0.0
    seen: dict[int, list[bool]] = {}
    for step, match in zip(steps, matches, strict=True):
        pair = np.flatnonzero(match.track != NOT_MATCHED)
        objects, tracks = objects + len(step.truth_id), tracks + len(step.track_id)
        pairs, switches = pairs + len(pair), switches + int(match.switched.sum())
        distance_m += float(step.distance[pair, match.track[pair]].sum())
        for truth, track in zip(step.truth_id.tolist(), match.track.tolist(), strict=True):
            seen.setdefault(truth, []).append(track != NOT_MATCHED)
    fragments = sum(_interruptions(found) for found in seen.values())
    return DistanceCounts(objects, pairs - switches, switches, objects - pairs, tracks - pairs, fragments, distance_m)


def _kept(step: DistanceStep, feasible: Bools, last: dict[int, int]) -> Ints:
    """(t,) tracks of the last matches that are still near; each track at most once."""
    track = np.full(len(step.truth_id), NOT_MATCHED)
    place = {identity: column for column, identity in enumerate(step.track_id.tolist())}
    for row, truth in enumerate(step.truth_id.tolist()):
        column = place.get(last.get(truth, NOT_MATCHED), NOT_MATCHED)
        if column != NOT_MATCHED and feasible[row, column] and column not in track:
            track[row] = column
    return track


def _assign(step: DistanceStep, feasible: Bools, track: Ints) -> None:
    """Assign the objects and tracks that are left, in `track`."""
    rows = np.flatnonzero(track == NOT_MATCHED)
    columns = np.setdiff1d(np.arange(len(step.track_id)), track)
    if not rows.size or not columns.size:
        return
    part = np.ix_(rows, columns)
    near = step.distance[part][feasible[part]]
    beyond = 1.0 + 2.0 * min(len(rows), len(columns)) * float(near.max(initial=0.0))  # dearer than all feasible pairs
    row, column = scipy.optimize.linear_sum_assignment(np.where(feasible[part], step.distance[part], beyond))
    good = feasible[part][row, column]
    track[rows[row[good]]] = columns[column[good]]


def _interruptions(matched: list[bool]) -> int:
    """Return how often an object is missed after a match and before its last match."""
    found = np.flatnonzero(matched)
    return int((np.diff(found) > 1).sum())


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

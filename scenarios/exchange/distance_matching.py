"""Frame-by-frame matching of truth and tracks by the distance of their centres, as nuScenes does.

nuScenes counts with py-motmetrics (Heindl 2017; Bernardin and Stiefelhagen 2008, CLEAR): an object keeps the track of
its last match, also after a gap, while they are closer than the limit. The others are assigned with as many pairs as
possible and then the least sum of distances. A pair with another track than at the last match is an id switch.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import scipy

from luxloop.scenarios.arrays import Bools, Floats, Ints

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

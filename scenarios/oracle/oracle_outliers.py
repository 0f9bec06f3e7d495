"""The truth for outlier removal: in a vehicle's segment the noise is removed, and nothing else of the vehicle.

Which lines the points that stay are on is told by the real stage, which does not see the noise; those that it would
remove are put on a line of their own, which tells no heading but counts for the sides. Points of something else in the
segment, a neighbour or a wall, are segmentation's mistake: they stay or go as the real stage says.

A segment of nothing but noise is gone: it has no rectangle and makes no box.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from scenarios.arrays import Bools
from tracker.detection.segmentation import keep_only
from tracker.records import NOT_USED, Candidates, Linkage, Segments

REMOVED = -1


def link(real: Callable[[Segments], Linkage], segments: Segments, noise: Bools, on_owner: Bools) -> Linkage:
    """Remove the noise, and let the real stage link what is left.

    Parameters
    ----------
    real
        Links the points of segments.
    noise
        (N,) which points are noise.
    on_owner
        (N,) which points lie on the actor that owns their segment.
    """
    clean = Segments(np.where(noise, NOT_USED, segments.label), segments.count)
    left = left_of(clean.label != NOT_USED, segments)
    linkage = real(keep_only(clean, left))
    heading = np.zeros(segments.count)
    heading[left] = linkage.heading
    wrongly_removed = on_owner & ~noise & (linkage.line == REMOVED)
    own_line = linkage.line.max(initial=0) + 1
    return Linkage(np.where(wrongly_removed, own_line, linkage.line), heading)


def left_of(points: Bools, segments: Segments) -> Bools:
    """(S,) whether any of the `points` (N,) is left of a segment."""
    return np.bincount(segments.label[points], minlength=segments.count) > 0


def stand_in(linkage: Linkage, segments: Segments, gone: Bools) -> Linkage:
    """Put the points of segments that are `gone` (S,) on a line after all: what fits them cannot do without."""
    of_gone = np.append(gone, False)[segments.label]
    return replace(linkage, line=np.where(of_gone, 0, linkage.line))


def without(candidates: Candidates, gone: Bools) -> Candidates:
    """Take the rectangles of segments that are `gone` (S,) away: no number, no box."""
    return replace(
        candidates,
        heading=np.where(gone[:, None], np.nan, candidates.heading),
        center_ego=np.where(gone[:, None, None], np.nan, candidates.center_ego),
        size=np.where(gone[:, None, None], np.nan, candidates.size),
    )

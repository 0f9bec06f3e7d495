"""Oracle for outlier removal: in the segment of a vehicle exactly the noise is removed.

The real stage assigns the remaining points to lines, without the noise. Points of the vehicle that it would remove get
a separate line, which has no effect on the heading but counts for the sides. Points of other objects in the segment, a
neighbour or a wall, are errors of segmentation: the real stage decides on them.

A segment that contains only noise gets no rectangle and no box.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from luxloop.scenarios.arrays import Bools
from luxloop.tracker.detection.segmentation import keep_only, regrouped
from luxloop.tracker.records import NOT_USED, Candidates, Linkage, SegmentedPoints, Segments

REMOVED = -1


def link(real: Callable[[SegmentedPoints], Linkage], points: SegmentedPoints, noise: Bools, on_owner: Bools) -> Linkage:
    """Remove the noise, and link the remaining points by the real stage.

    Parameters
    ----------
    real
        The real stage.
    noise
        (N,) mask of noise.
    on_owner
        (N,) mask of points on the owner of their segment.
    """
    segments = points.segments
    clean = Segments(np.where(noise, NOT_USED, segments.label), segments.count)
    remaining = has_points(clean.label != NOT_USED, segments)
    linkage = real(regrouped(points, keep_only(clean, remaining)))
    heading = np.zeros(segments.count)
    heading[remaining] = linkage.heading
    wrongly_removed = on_owner & ~noise & (linkage.line == REMOVED)
    own_line = linkage.line.max(initial=0) + 1
    return Linkage(np.where(wrongly_removed, own_line, linkage.line), heading)


def has_points(points: Bools, segments: Segments) -> Bools:
    """(S,) mask of segments that contain at least one point of the mask `points` (N,)."""
    return np.bincount(segments.label[points], minlength=segments.count) > 0


def with_placeholder_lines(linkage: Linkage, segments: Segments, gone: Bools) -> Linkage:
    """Put the points of segments that are `gone` (S,) on a line, because the fit needs one."""
    of_gone = np.append(gone, False)[segments.label]
    return replace(linkage, line=np.where(of_gone, 0, linkage.line))


def without_rectangles(candidates: Candidates, gone: Bools) -> Candidates:
    """Set the rectangles of segments that are `gone` (S,) to NaN, so that they get no box."""
    return replace(
        candidates,
        heading=np.where(gone[:, None], np.nan, candidates.heading),
        center_ego=np.where(gone[:, None, None], np.nan, candidates.center_ego),
        size=np.where(gone[:, None, None], np.nan, candidates.size),
    )

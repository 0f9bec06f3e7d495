"""Walls in a segment that is too long for a vehicle: straight runs of points, apart from the vehicles chained to them.

A wall is a thin structure without gaps that is longer than any vehicle, straight or in straight parts. A queue of
vehicles is as long, but has gaps between its flanks, and each flank is shorter than a part of a wall. A vehicle beside
a wall lies off its line.
"""

import math
from dataclasses import replace

import numpy as np
import scipy

from tracker.arrays import Bools, Floats, Ints
from tracker.detection.segmentation import SegmentationConfig, connect
from tracker.detection.straight_runs import RunConfig, straight_runs
from tracker.records import NOT_USED

TIGHT = 0.5
"""Share of the segmentation's radius within which parts of one wall follow one another: queued vehicles are farther
apart, and adjacent points on a wall are nearer."""


def split(points: Floats, length_min_m: float, runs: RunConfig, segmentation: SegmentationConfig) -> tuple[Bools, Ints]:
    """Split a segment that is too long for a vehicle into walls and other objects.

    Parameters
    ----------
    points
        (P, 2) relative to the ego's centre [m].
    length_min_m
        Structures longer than this are walls [m].

    Returns
    -------
    wall
        (P,) mask of points on walls.
    label
        (P,) number of the other object that each point belongs to, `NOT_USED` for walls and for small parts.
    """
    run = straight_runs(points, runs, segmentation)
    straight = np.flatnonzero(run != NOT_USED)
    wall = np.zeros(len(points), np.bool_)
    chain = chained(points[straight], run[straight], tight(segmentation))
    wall[straight] = extents(points[straight], chain)[chain] > length_min_m
    rest = np.flatnonzero(~wall)
    part = parts(points[rest], segmentation)
    long = extents(points[rest], part)[part] > length_min_m
    part[long] = parts(points[rest[long]], tight(segmentation)) + len(rest)
    part = np.unique(part, return_inverse=True)[1]
    wall[rest] = extents(points[rest], part)[part] > length_min_m
    label = np.full(len(points), NOT_USED)
    label[rest] = np.where(wall[rest], NOT_USED, part)
    return wall, facets_dropped(points, wall, label, runs, segmentation.points_min)


def facets_dropped(points: Floats, wall: Bools, label: Ints, runs: RunConfig, points_min: int) -> Ints:
    """Return the labels (P,), numbered from 0, without parts that are too small and thin ones that touch the `wall`.

    These are the short facets of a wall, and points of its rough surface.
    """
    label = label.copy()
    used = np.flatnonzero(label != NOT_USED)
    if not len(used):
        return label
    distance = (
        scipy.spatial.cKDTree(points[wall]).query(points[used])[0] if wall.any() else np.full(len(used), math.inf)
    )
    for number in np.unique(label[used]):
        own = label[used] == number
        touches = distance[own].min() <= runs.touch_m and thickness(points[used[own]]) <= 2 * runs.half_width_m
        if own.sum() < points_min or touches:
            label[used[own]] = NOT_USED
    used = label != NOT_USED
    label[used] = np.unique(label[used], return_inverse=True)[1]
    return label


def thickness(points: Floats) -> float:
    """Smallest extent of points (P, 2) over directions 11.25 degrees apart [m]."""
    angle = np.arange(0.0, np.pi, np.pi / 16)
    return float(np.ptp(points @ np.array([np.cos(angle), np.sin(angle)]), axis=0).min())


def tight(segmentation: SegmentationConfig) -> SegmentationConfig:
    """Return the segmentation with the radius within which parts of one wall follow one another."""
    return replace(segmentation, radius_m=TIGHT * segmentation.radius_m, radius_per_m=TIGHT * segmentation.radius_per_m)


def chained(points: Floats, run: Ints, segmentation: SegmentationConfig) -> Ints:
    """(P,) number of the chain of runs that each point is in: runs of which points are connected form a chain."""
    if not len(points):
        return run
    part = parts(points, segmentation) + run.max() + 1
    links = scipy.sparse.coo_array((np.ones(len(run)), (run, part)), shape=(part.max() + 1,) * 2)
    return np.asarray(scipy.sparse.csgraph.connected_components(links, directed=False)[1][run], dtype=np.int64)


def parts(points: Floats, segmentation: SegmentationConfig) -> Ints:
    """(P,) number of the connected part of each point (P, 2) [m]."""
    return np.asarray(np.unique(connect(points, segmentation), return_inverse=True)[1], dtype=np.int64)


def extents(points: Floats, part: Ints) -> Floats:
    """(max part + 1,) largest extent of each part of points (P, 2) [m], at most 2 % below its diameter."""
    if not len(points):
        return np.zeros(0)
    order = np.argsort(part, kind="stable")
    start = np.searchsorted(part[order], np.arange(part.max() + 1))
    filled = np.flatnonzero(np.diff(start, append=len(part)))
    found = np.zeros(len(start))
    found[filled] = extent(points[order], np.append(start[filled], len(part)))
    return found


def extent(points: Floats, offset: Ints) -> Floats:
    """(S,) largest extent of each segment of points (N, 2) over directions 22.5 degrees apart [m].

    At most 2 % below the diameter of the segment.
    """
    angle = np.arange(0.0, np.pi, np.pi / 8)
    along = points @ np.array([np.cos(angle), np.sin(angle)])
    low, high = np.minimum.reduceat(along, offset[:-1]), np.maximum.reduceat(along, offset[:-1])
    return np.asarray(np.max(high - low, axis=1))

"""Walls in a segment that is too long for a vehicle, apart from the vehicles chained to them.

A wall is a thin structure without gaps that is longer than any vehicle, straight or of straight parts. A queue of
vehicles is as long, but has gaps between its flanks, and each flank is shorter than a part of a wall. A vehicle beside
a wall lies off its line.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.tracker.detection.point_groups import any_within, extents_along
from luxloop.tracker.detection.segmentation import SegmentationConfig, connect
from luxloop.tracker.records import NOT_USED

TIGHT = 0.5
"""Share of the segmentation's radius within which parts of one wall follow one another: queued vehicles are farther
apart, and adjacent points on a wall are nearer."""
ANGLES = np.arange(0.0, np.pi, np.pi / 8)
NORMALS = np.arange(0.0, math.pi, math.radians(3.0))
"""Directions of the normals of lines [rad]; the fit that follows finds the angle between two of them."""
FITS = 3
"""Fits of a line to the points in its band: the bands of the first ones leave out the ends of a long wall."""
TRIALS = 8
"""Lines to try in one segment."""
RUN_LENGTH_MIN_M = 6.0
"""Minimum length of a straight part of a wall [m]; the flank of a van is shorter."""
HALF_WIDTH_M = 0.25
"""Maximum distance of its points from the line [m]: range noise, calibration errors, pilasters."""
GAP_M = 0.25
"""Maximum gap on a surface that is seen frontally [m]."""


def split(
    points: Floats,
    segment: Ints,
    known: Bools,
    length_min_m: float,
    beam_rad: float,
    segmentation: SegmentationConfig,
) -> tuple[Bools, Ints]:
    """Split segments that are too long for a vehicle into walls and other objects.

    Parameters
    ----------
    points
        (P, 2) relative to the ego's centre [m].
    segment
        (P,) segment of each point.
    known
        (P,) mask of points where a wall is remembered. Other walls are searched for only if the rest may be a part of
        one.
    length_min_m
        Structures longer than this are walls [m].
    beam_rad
        Angle between beams of one layer [rad].

    Returns
    -------
    wall
        (P,) mask of points on walls.
    label
        (P,) number of the other object that each point belongs to, `NOT_USED` for walls and for small parts; some
        numbers may be unused.
    """
    wall, label = part_objects(points, known, length_min_m, segmentation)
    is_searched = np.bincount(segment) > 0
    is_searched[segment[known]] = False
    is_searched[segment[label != NOT_USED]] = True
    searched = np.flatnonzero(is_searched)
    if not len(searched):
        return wall, label
    wall = known.copy()
    for number in searched:
        own = np.flatnonzero(segment == number)
        wall[own] |= chains_of_runs(points[own], length_min_m, beam_rad, segmentation)
    wall, label = part_objects(points, wall, length_min_m, segmentation)
    used = np.flatnonzero(label != NOT_USED)
    hedge = used[(extents(points[used], label[used]) > length_min_m)[label[used]]]  # without gaps, but not straight
    wall[hedge], label[hedge] = True, NOT_USED
    return wall, label


def part_objects(
    points: Floats, wall: Bools, length_min_m: float, segmentation: SegmentationConfig
) -> tuple[Bools, Ints]:
    """Part the points (P, 2) not on a known `wall` (P,) into objects, and return what `split` does.

    Thin parts that touch the wall belong to it: facets too short for a run, and points of a rough surface.
    """
    wall, label = wall.copy(), np.full(len(points), NOT_USED)
    rest = np.flatnonzero(~wall)
    if len(rest) < segmentation.points_min:
        return wall, label
    part = halved(points[rest], parts(points[rest], segmentation), length_min_m, segmentation)
    more = extents(points[rest], part, np.min) <= 2.0 * HALF_WIDTH_M
    more &= touching(points, wall, rest, part, segmentation)
    kept = ~more & (np.bincount(part, minlength=len(more)) >= segmentation.points_min)
    wall[rest[more[part]]] = True
    label[rest] = np.where(kept, np.cumsum(kept) - 1, NOT_USED)[part]
    return wall, label


def halved(points: Floats, part: Ints, length_min_m: float, segmentation: SegmentationConfig) -> Ints:
    """(R,) parts of points (R, 2), of which those that are too long for a vehicle are split at the tight radius."""
    long = extents(points, part)[part] > length_min_m
    part = part.copy()
    part[long] = parts(points[long], tight(segmentation)) + len(part)
    return numbered(part)


def touching(points: Floats, wall: Bools, rest: Ints, part: Ints, segmentation: SegmentationConfig) -> Bools:
    """(max part + 1,) mask of parts of the `rest` (R,) that follow a wall without a gap."""
    close = tight(segmentation)
    radius = close.radius_m + close.radius_per_m * np.sqrt(np.sum(points[rest] ** 2, axis=1))
    return np.bincount(part, any_within(points[rest], points[wall], radius)) > 0


def tight(segmentation: SegmentationConfig) -> SegmentationConfig:
    """Return the segmentation with the radius within which parts of one wall follow one another."""
    return replace(segmentation, radius_m=TIGHT * segmentation.radius_m, radius_per_m=TIGHT * segmentation.radius_per_m)


def chains_of_runs(points: Floats, length_min_m: float, beam_rad: float, segmentation: SegmentationConfig) -> Bools:
    """(P,) mask of points (P, 2) in chains of straight runs longer than `length_min_m` [m].

    Other points on their lines belong to the same walls: the beams are far apart on a wall at a grazing angle, and
    traffic occludes parts of it.
    """
    run, line = straight_runs(points, beam_rad, segmentation)
    straight = np.flatnonzero(run != NOT_USED)
    found = np.zeros(len(points), np.bool_)
    if len(straight):
        chain = chained(points[straight], run[straight], tight(segmentation))
        long = extents(points[straight], chain)[chain] > length_min_m
        found = np.isin(line, line[straight[long]])
    return found


def chained(points: Floats, run: Ints, segmentation: SegmentationConfig) -> Ints:
    """(P,) number of the chain of runs that each point is in: runs of which points are connected form a chain."""
    if run.max() == 0:
        return run
    part = parts(points, segmentation) + run.max() + 1
    links = scipy.sparse.coo_array((np.ones(len(run)), (run, part)), shape=(part.max() + 1,) * 2)
    return np.asarray(scipy.sparse.csgraph.connected_components(links, directed=False)[1][run], dtype=np.int64)


def parts(points: Floats, segmentation: SegmentationConfig) -> Ints:
    """(P,) number of the connected part of each point (P, 2) [m]."""
    return numbered(connect(points, segmentation))


def numbered(names: Ints) -> Ints:
    """(P,) names, 0 or more, renumbered from 0 without gaps, in their order."""
    return np.asarray((np.cumsum(np.bincount(names) > 0) - 1)[names])


def extents(points: Floats, part: Ints, over: Callable[..., Floats] = np.max) -> Floats:
    """(max part + 1,) largest or smallest extent of each part of points (P, 2) over directions 22.5 degrees apart [m].

    The largest is at most 2 % below the diameter of the part.
    """
    directions = np.column_stack([elementwise.cos(ANGLES), elementwise.sin(ANGLES)])
    return np.asarray(over(extents_along(points, part, int(part.max(initial=-1)) + 1, directions), axis=1))


def straight_runs(points: Floats, beam_rad: float, segmentation: SegmentationConfig) -> tuple[Ints, Ints]:
    """Return the straight run (P,) and the line (P,) of each point, `NOT_USED` for points on none.

    Points (P, 2) are relative to the ego's centre [m]. A line may have several runs, with gaps between them.
    """
    found, line_of = np.full(len(points), NOT_USED), np.full(len(points), NOT_USED)
    cells = thinned(points, HALF_WIDTH_M)
    left = np.ones(len(cells), np.bool_)
    needed = max(2.0, 0.5 * RUN_LENGTH_MIN_M / HALF_WIDTH_M)  # half of a run's cells
    for trial in range(TRIALS):
        candidates = np.flatnonzero(left)
        if len(candidates) < needed:
            break
        band = candidates[densest_line(cells[candidates], HALF_WIDTH_M)]
        if len(band) < needed:
            break
        line = fitted(cells, band, HALF_WIDTH_M)
        near = left & (np.abs(elementwise.product(cells, line[:2]) - line[2]) <= 2.0 * HALF_WIDTH_M)
        near[band] = True
        left &= ~near
        on_line = np.flatnonzero(
            (found == NOT_USED) & (np.abs(elementwise.product(points, line[:2]) - line[2]) <= HALF_WIDTH_M)
        )
        run = unbroken(points[on_line], line, beam_rad, segmentation)
        run[run != NOT_USED] += found.max(initial=NOT_USED) + 1
        found[on_line] = run
        line_of[on_line] = trial
    return found, line_of


def thinned(points: Floats, pitch: float) -> Floats:
    """(C, 2) means of points (P, 2) by square cells [m].

    A line's votes then follow its length, not the density of its points.
    """
    column, row = np.floor(points / pitch).astype(np.int64).T
    _, member, count = np.unique((column << 32) + row, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(member, axis, len(count)) for axis in points.T], axis=1)
    return np.asarray(sums / count[:, None])


def densest_line(cells: Floats, half_width: float) -> Ints:
    """Return the cells (C, 2) in the band of a line that holds most of them; bands do not overlap."""
    offset = elementwise.product(cells, np.array([elementwise.cos(NORMALS), elementwise.sin(NORMALS)]))
    band = np.floor(offset / (2.0 * half_width)).astype(np.int64)
    band -= band.min()
    width = int(band.max()) + 1
    votes = np.bincount((band + width * np.arange(len(NORMALS))).ravel(), minlength=width * len(NORMALS))
    best = int(votes.argmax())
    return np.flatnonzero(band[:, best // width] == best % width)


def fitted(cells: Floats, band: Ints, half_width: float) -> Floats:
    """Return a line's unit normal and offset (3,): principal axes of the cells in its band, which follows the fit."""
    line = np.zeros(3)
    for _ in range(FITS):
        mean = cells[band].mean(axis=0)
        away = cells[band] - mean
        (xx, xy), (_, yy) = elementwise.product(away.T, away)
        direction = 0.5 * elementary.atan2(2.0 * xy, xx - yy)
        line[:2] = -elementary.sin(direction), elementary.cos(direction)
        line[2] = elementwise.product(line[:2], mean)
        inside = np.flatnonzero(np.abs(elementwise.product(cells, line[:2]) - line[2]) <= half_width)
        if len(inside) < len(band):
            break
        band = inside
    return line


def unbroken(points: Floats, line: Floats, beam_rad: float, segmentation: SegmentationConfig) -> Ints:
    """(P,) run of each point on a line: parts without gaps that are long enough, numbered along the line."""
    if not len(points):
        return np.empty(0, dtype=np.int64)
    along = elementwise.product(points, np.array([-line[1], line[0]]))
    order = np.argsort(along, kind="stable")
    along = along[order]
    range_m = elementwise.hypot(along, line[2])
    grazing = GAP_M + 3.0 * beam_rad * range_m**2 / max(abs(float(line[2])), GAP_M)
    limit = np.minimum(segmentation.radius_m + segmentation.radius_per_m * range_m, grazing)
    broken = np.diff(along, prepend=along[0]) > np.maximum(limit, np.append(limit[0], limit[:-1]))
    piece = np.cumsum(broken)
    start = np.searchsorted(piece, np.arange(piece[-1] + 1))
    length = np.maximum.reduceat(along, start) - along[start]
    run = np.empty(len(points), dtype=np.int64)
    long = length >= RUN_LENGTH_MIN_M
    run[order] = np.where(long, np.cumsum(long) - 1, NOT_USED)[piece]
    return run

"""Lines of sight between vehicles, seen from above."""

from collections.abc import Iterator

import numpy as np
import scipy

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints

CHUNK = 400_000
"""Triples of ego, neighbour and blocker that are tested at a time; it bounds the memory."""


def count_near(place: Floats, counted: Bools, range_m: float) -> Ints:
    """Return the number (N,) of other counted bodies within a range.

    Parameters
    ----------
    place
        (N, 2) box centres [m].
    counted
        (N,) bodies that count.
    range_m
        Range [m], inclusive.
    """
    if not counted.any():
        return np.zeros(len(place), dtype=np.int64)
    found = scipy.spatial.cKDTree(place[counted]).query_ball_point(place, range_m, return_length=True)
    return np.asarray(found, dtype=np.int64) - counted


def count_blocked(pose: Floats, size: Floats, counted: Bools, range_m: float) -> Ints:
    """Return the number (N,) of counted bodies within a range whose line of sight is blocked.

    The line connects the box centres. It is blocked if the box of a third body intersects it. Heights are ignored.

    Parameters
    ----------
    pose
        (N, 3) box centre x [m], y [m], yaw [rad].
    size
        (N, 2) length, width [m].
    counted
        (N,) bodies that count as neighbours; all bodies block.
    range_m
        Range [m], inclusive.
    """
    blocked = np.zeros(len(pose), dtype=np.int64)
    pairs = np.empty((0, 2), int)
    if len(pose):
        pairs = scipy.spatial.cKDTree(pose[:, :2]).query_pairs(range_m, output_type="ndarray")
    if not len(pairs):
        return blocked
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    x, y = (pose[pairs[:, 1], :2] - pose[pairs[:, 0], :2]).T
    distance = np.maximum(elementwise.hypot(x, y), 1e-9)
    radius = 0.5 * elementwise.hypot(*size.T)[pairs[:, 1]]
    count = np.bincount(pairs[:, 0], minlength=len(pose))
    first = np.cumsum(count) - count
    for line in _chunks(np.flatnonzero(counted[pairs[:, 1]]), count[pairs[:, 0]]):
        ego = pairs[line, 0]
        target = np.repeat(line, count[ego])
        start = np.repeat(np.cumsum(count[ego]) - count[ego] - first[ego], count[ego])
        blocker = np.arange(len(target)) - start  # the pairs of the same ego, for each of its lines
        # a circle around the box excludes most of them
        ahead = (x[target] * x[blocker] + y[target] * y[blocker]) / distance[target]
        aside = np.abs(x[target] * y[blocker] - y[target] * x[blocker]) / distance[target]
        near = (aside <= radius[blocker]) & (ahead > -radius[blocker]) & (ahead < distance[target] + radius[blocker])
        near &= target != blocker
        target, blocker = target[near], blocker[near]
        box = pairs[blocker, 1]
        hit = _intersects(np.column_stack([x, y])[target], np.column_stack([x, y])[blocker], pose[box, 2], size[box])
        hidden = np.unique(target[hit])
        blocked += np.bincount(pairs[hidden, 0], minlength=len(pose))
    return blocked


def _chunks(rows: Ints, cost: Ints) -> Iterator[Ints]:
    """Yield parts of the rows of pairs (P,) whose costs sum up to about `CHUNK`."""
    if len(rows):
        part = np.cumsum(cost[rows]) // CHUNK
        yield from np.split(rows, np.flatnonzero(np.diff(part)) + 1)


def _intersects(end: Floats, centre: Floats, yaw: Floats, size: Floats) -> Bools:
    """Return True (M,) for segments from the origin that intersect a box, by its slabs (Kay and Kajiya, SIGGRAPH 1986).

    Parameters
    ----------
    end, centre
        (M, 2) ends of the segments and centres of the boxes, relative to the segments' beginnings [m].
    yaw, size
        (M,) [rad] and (M, 2) [m] of the boxes.
    """
    enter, leave = np.zeros(len(end)), np.ones(len(end))
    cos, sin = elementwise.cos(yaw), elementwise.sin(yaw)
    for axis, (x, y) in enumerate(((cos, sin), (-sin, cos))):
        origin = -(centre[:, 0] * x + centre[:, 1] * y)
        direction = end[:, 0] * x + end[:, 1] * y
        direction = np.where(np.abs(direction) < 1e-12, 1e-12, direction)
        bounds = (np.array([[-0.5], [0.5]]) * size[:, axis] - origin) / direction
        enter, leave = np.maximum(enter, bounds.min(axis=0)), np.minimum(leave, bounds.max(axis=0))
    return np.asarray(enter <= leave)

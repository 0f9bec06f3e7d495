"""Lines of sight between vehicles, seen from above."""

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from sim.arrays import Bools, Floats, Ints

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
    found = cKDTree(place[counted]).query_ball_point(place, range_m, return_length=True)
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
    pairs = cKDTree(pose[:, :2]).query_pairs(range_m, output_type="ndarray") if len(pose) else np.empty((0, 2), int)
    if not len(pairs):
        return blocked
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    count = np.bincount(pairs[:, 0], minlength=len(pose))
    first = np.cumsum(count) - count
    for part in _chunks(np.flatnonzero(counted[pairs[:, 1]]), count[pairs[:, 0]]):
        ego, target = pairs[part].T
        line = np.repeat(np.arange(len(part)), count[ego])
        place = np.arange(len(line)) - np.repeat(np.cumsum(count[ego]) - count[ego], count[ego])
        blocker = pairs[np.repeat(first[ego], count[ego]) + place, 1]
        hit = _intersects(pose[ego[line], :2], pose[target[line], :2], pose[blocker], size[blocker])
        hit &= blocker != target[line]
        hidden = np.bincount(line[hit], minlength=len(part)) > 0
        blocked += np.bincount(ego[hidden], minlength=len(pose))
    return blocked


def _chunks(rows: Ints, cost: Ints) -> Iterator[Ints]:
    """Yield parts of the rows of pairs (P,) whose costs sum up to about `CHUNK`."""
    if len(rows):
        part = np.cumsum(cost[rows]) // CHUNK
        yield from np.split(rows, np.flatnonzero(np.diff(part)) + 1)


def _intersects(start: Floats, end: Floats, pose: Floats, size: Floats) -> Bools:
    """Return True (M,) for line segments that intersect a box.

    First a circle around the box excludes most of them, then the slabs of the box decide (Kay and Kajiya, SIGGRAPH
    1986).
    """
    along, centre = end - start, pose[:, :2] - start
    length = np.maximum(np.hypot(*along.T), 1e-9)
    radius = 0.5 * np.hypot(*size.T)
    ahead = (along * centre).sum(axis=1) / length
    aside = np.abs(along[:, 0] * centre[:, 1] - along[:, 1] * centre[:, 0]) / length
    hit = (aside <= radius) & (ahead > -radius) & (ahead < length + radius)
    row = np.flatnonzero(hit)
    cos, sin = np.cos(pose[row, 2]), np.sin(pose[row, 2])
    enter, leave = np.zeros(len(row)), np.ones(len(row))
    for axis, (x, y) in enumerate(((cos, sin), (-sin, cos))):
        origin = -(centre[row, 0] * x + centre[row, 1] * y)
        direction = along[row, 0] * x + along[row, 1] * y
        direction = np.where(np.abs(direction) < 1e-12, 1e-12, direction)
        bounds = (np.array([[-0.5], [0.5]]) * size[row, axis] - origin) / direction
        enter, leave = np.maximum(enter, bounds.min(axis=0)), np.minimum(leave, bounds.max(axis=0))
    hit[row] = enter <= leave
    return hit

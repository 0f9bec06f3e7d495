"""Kernels of points in groups: order by group, positions, means and extents."""

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel


@kernel()
def by_group(label: Ints, count: int) -> tuple[Ints, Ints]:
    """Return the indices of points with labels 0 to `count` - 1 by label and in their order, and starts (count + 1,).

    Points (N,) with a negative label are left out. A counting sort.
    """
    start = np.zeros(count + 1, np.int64)
    for i in range(len(label)):
        if label[i] >= 0:
            start[label[i] + 1] += 1
    for g in range(count):
        start[g + 1] += start[g]
    order, place = np.empty(start[count], np.int64), start.copy()
    for i in range(len(label)):
        if label[i] >= 0:
            order[place[label[i]]] = i
            place[label[i]] += 1
    return order, start


@kernel()
def positions(points: Floats, index: Ints) -> Floats:
    """(K, 2) x and y of the points (N, 2 or more) of `index` (K,) [m]."""
    found = np.empty((len(index), 2))
    for k in range(len(index)):
        found[k, 0], found[k, 1] = points[index[k], 0], points[index[k], 1]
    return found


@kernel()
def columns(points: Floats) -> tuple[Floats, Floats]:
    """(N,) x and y of points (N, 2 or more), each contiguous: loops over rows of unknown length are not vectorised."""
    return points[:, 0].copy(), points[:, 1].copy()


@kernel(error_model="numpy")
def means(points: Floats, label: Ints, count: int) -> Floats:
    """(count, 2) mean of each group of points (N, 2 or more); points with a negative label belong to no group."""
    mean, size = np.zeros((count, 2)), np.zeros(count)
    for i in range(len(points)):
        g = label[i]
        if g >= 0:
            mean[g, 0] += points[i, 0]
            mean[g, 1] += points[i, 1]
            size[g] += 1.0
    for g in range(count):
        mean[g, 0] /= size[g]
        mean[g, 1] /= size[g]
    return mean


@kernel()
def extents_along(points: Floats, label: Ints, count: int, directions: Floats) -> Floats:
    """(count, D) extent of each group of points (N, 2) along unit vectors (D, 2) [m]; -inf for groups without points.

    Points with a negative label belong to no group.
    """
    low, high = np.full((count, len(directions)), np.inf), np.full((count, len(directions)), -np.inf)
    for i in range(len(points)):
        g = label[i]
        if g >= 0:
            for d in range(len(directions)):
                place = points[i, 0] * directions[d, 0] + points[i, 1] * directions[d, 1]
                low[g, d], high[g, d] = min(low[g, d], place), max(high[g, d], place)
    for g in range(count):
        for d in range(len(directions)):
            high[g, d] -= low[g, d]
    return high

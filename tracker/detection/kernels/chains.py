"""Kernels of segmentation: connected components of points."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.ordering import by_number


@kernel()
def find_root(parent: Ints, i: int) -> int:
    """Return the representative of the set of i, with path halving."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@kernel()
def unite(parent: Ints, a: int, b: int) -> None:
    """Merge two sets; the lower index represents both."""
    a, b = find_root(parent, a), find_root(parent, b)
    parent[max(a, b)] = min(a, b)


@kernel()
def connect_cells(points: Floats, radius: Floats, parent: Ints, a: int, a_end: int, b: int, b_end: int) -> None:
    """Merge the sets of two cells at the first pair of points within either point's radius."""
    if find_root(parent, a) == find_root(parent, b):
        return
    for i in range(a, a_end):
        for j in range(b, b_end):
            dx, dy = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
            reach = max(radius[i], radius[j])
            if dx * dx + dy * dy <= reach * reach:
                unite(parent, i, j)
                return


@kernel()
def cell_starts(column: Ints, row: Ints) -> Ints:
    """(C + 1,) first point of each of the C cells that have points, of points (N,) sorted by cell, and N."""
    start, count = np.zeros(len(column) + 1, np.int64), 1
    for k in range(1, len(column)):
        if column[k] != column[k - 1] or row[k] != row[k - 1]:
            start[count] = k
            count += 1
    start[count] = len(column)
    return start[: count + 1]


@kernel()
def first_of_each(parent: Ints, order: Ints) -> Ints:
    """(N,) lowest index of the points in the set of each point; place k of `parent` (N,) is point order[k]."""
    first = np.full(len(parent), len(parent))
    for k in range(len(parent)):
        parent[k] = find_root(parent, k)
        first[parent[k]] = min(first[parent[k]], order[k])
    found = np.empty(len(parent), np.int64)
    for k in range(len(parent)):
        found[order[k]] = first[parent[k]]
    return found


@kernel()
def connected(points: Floats, radius_m: float, radius_per_m: float) -> Ints:
    """(N,) index of the first point of the component of each point, connected by pairs within either point's radius.

    The radius of points (N, 2) grows with range, see `SegmentationConfig`. They are sorted by grid cells, by column and
    then by row. The diagonal of a cell is at most the smallest radius, so that a cell is one set from the start.
    """
    radius, least, largest = np.empty(len(points)), np.inf, 0.0
    for i in range(len(points)):
        radius[i] = radius_m + radius_per_m * math.sqrt(points[i, 0] ** 2 + points[i, 1] ** 2)
        least, largest = min(least, radius[i]), max(largest, radius[i])
    column, row = np.empty(len(points), np.int64), np.empty(len(points), np.int64)
    pitch = least / math.sqrt(2.0)
    for i in range(len(points)):
        column[i], row[i] = math.floor(points[i, 0] / pitch), math.floor(points[i, 1] / pitch)
    order = by_number(column, by_number(row, np.arange(len(points))))
    parent = united(points[order], radius[order], column[order], row[order], math.ceil(largest / pitch))
    return first_of_each(parent, order)


@kernel()
def united(points: Floats, radius: Floats, column: Ints, row: Ints, window: int) -> Ints:
    """(N,) a member of the set of each point, for points sorted by the `column` (N,) and the `row` (N,) of their cell.

    Columns and rows are overwritten. Pairs within either point's radius are at most `window` cells apart.
    """
    parent, cell = np.empty(len(points), np.int64), cell_starts(column, row)
    cells = len(cell) - 1
    for a in range(cells):
        for k in range(cell[a], cell[a + 1]):
            parent[k] = cell[a]
        column[a], row[a] = column[cell[a]], row[cell[a]]  # from here on those of the cells
    for shift in range(window + 1):
        start = 0
        for a in range(cells):
            first = row[a] + 1 if shift == 0 else row[a] - window
            while start < cells and (
                column[start] < column[a] + shift or (column[start] == column[a] + shift and row[start] < first)
            ):
                start += 1
            b = start
            while b < cells and column[b] == column[a] + shift and row[b] <= row[a] + window:
                connect_cells(points, radius, parent, cell[a], cell[a + 1], cell[b], cell[b + 1])
                b += 1
    return parent

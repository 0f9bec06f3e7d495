"""Kernels of segmentation: connected components of points."""

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints


@njit(cache=True)
def find_root(parent: Ints, i: int) -> int:
    """Return the representative of the set of i, with path halving."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True)
def unite(parent: Ints, a: int, b: int) -> None:
    """Merge two sets; the lower index represents both."""
    a, b = find_root(parent, a), find_root(parent, b)
    parent[max(a, b)] = min(a, b)


@njit(cache=True)
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


@njit(cache=True)
def connected(points: Floats, radius: Floats, column: Ints, row: Ints, cell: Ints, window: int) -> Ints:
    """Return the set of each point, connected by pairs within either point's radius.

    Points are sorted by grid cell (column, then row); cell c holds points cell[c] to cell[c + 1] and lies in
    column[c], row[c]. A cell's diagonal is at most the smallest radius, so that a cell is one set from the
    start; pairs are at most `window` cells apart.
    """
    parent = np.arange(len(points))
    cells = len(cell) - 1
    for a in range(cells):
        parent[cell[a] : cell[a + 1]] = cell[a]
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
    for i in range(len(points)):
        parent[i] = find_root(parent, i)
    return parent

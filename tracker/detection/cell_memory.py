"""Memory of places: occupancy of square cells in log-odds (Moravec and Elfes 1985), with forgetting."""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.detection.kernels.cells import contained

HALF = 1 << 32
"""A cell's number is its column times this, plus its row."""


class CellMemory:
    """Sorted set of cells with log-odds."""

    def __init__(self, pitch_m: float) -> None:
        self._pitch_m = pitch_m
        self.cells: Ints = np.empty(0, dtype=np.int64)
        self.log_odds: Floats = np.empty(0)

    def cell(self, points: Floats) -> Ints:
        """(N,) cell number of each point (N, 2) [m]."""
        place = np.floor(points / self._pitch_m).astype(np.int64)
        return place[:, 0] * HALF + place[:, 1]

    def centers(self) -> Floats:
        """(C, 2) centres of the cells [m]."""
        row = (self.cells + HALF // 2) % HALF - HALF // 2
        return self._pitch_m * (np.stack([(self.cells - row) // HALF, row], axis=1) + 0.5)

    def strengthen(self, cells: Ints, gain: float, largest: float) -> None:
        """Add `gain` to the log-odds of distinct sorted `cells` (N,), 0 before if new, up to `largest`."""
        new = cells[~self.contains(cells)]
        place = np.searchsorted(self.cells, new)
        self.cells = np.insert(self.cells, place, new)
        self.log_odds = np.insert(self.log_odds, place, 0.0)
        own = np.searchsorted(self.cells, cells)
        self.log_odds[own] = np.minimum(self.log_odds[own] + gain, largest)

    def weaken(self, loss: Floats, factor: float, smallest: float) -> None:
        """Multiply the log-odds by `factor`, subtract `loss` (C,), and drop cells below `smallest`."""
        log_odds = factor * self.log_odds - loss
        kept = log_odds >= smallest
        self.cells, self.log_odds = self.cells[kept], log_odds[kept]

    def contains(self, cells: Ints) -> Bools:
        """(N,) mask of cells in the set; a binary search, because a long drive adds very many."""
        return contained(cells, self.cells)

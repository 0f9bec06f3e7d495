"""Background model: cells where a wall was seen.

A wall is recognised by its length while most of it is visible. When traffic occludes parts of it, the rest may have the
size of a truck. Cells that a wall covers are therefore stored, in the odometry frame, as an occupancy grid in log-odds
(Moravec and Elfes 1985; increments of Hornung et al. 2013). A cell is forgotten when beams pass it, and in time.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker import free_space
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.segmentation import SegmentationConfig, keep_only
from luxloop.tracker.detection.walls import extents, split
from luxloop.tracker.records import NOT_USED, Segments

EGO: tuple[float, float] = (0.0, 0.0)
CELL_M = 0.5
"""Size of a cell [m]."""
KNOWN_FRACTION_MAX = 0.5
"""A segment with a larger fraction of its points in background cells is background."""
HIT_LOG_ODDS = 0.85
"""Evidence of a wall in a cell per scan, log-odds: a probability of 0.7 (Hornung et al. 2013)."""
PASSED_LOG_ODDS = 0.4
"""Evidence against it if all beams pass the cell, log-odds: a probability of 0.4 (same source)."""
LOG_ODDS_MAX = 3.5
"""Limit of the evidence, log-odds (same source): a cell is forgotten when beams pass it for 2 s."""
LOG_ODDS_MIN = 0.4
"""Cells with less evidence are forgotten, log-odds."""
PASSED_INTERVAL_S = 0.25
"""Time between two tests for passing beams [s]: successive scans show the same and are no independent evidence."""
SEARCH_INTERVAL_S = 1.0
"""Time between two searches for walls that include the remembered ones [s]: only what is found strengthens them."""
HALF = 1 << 32
"""A cell's number is its column times this, plus its row."""


@dataclass(frozen=True, slots=True)
class BackgroundConfig:
    """Length and memory of walls."""

    length_min_m: float = 20.0
    """Segments longer than this contain background [m]; an articulated bus measures 17.9. Raise it to track trams."""
    memory_s: float = 60.0
    """Time in which the evidence of an unseen cell decreases by a factor of e [s]; waiting traffic may hide a wall for
    as long. Lower it if odometry drifts."""

    def __post_init__(self) -> None:
        for name in ("length_min_m", "memory_s"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give a value above 0")


class Background:
    """Removal of walls. Its memory is the occupancy of the cells where walls were seen."""

    def __init__(
        self,
        config: BackgroundConfig,
        segmentation: SegmentationConfig | None = None,
        lidar: LidarConfig | None = None,
    ) -> None:
        self._config = config
        self._segmentation = segmentation or SegmentationConfig()
        self._beam_rad = (lidar or LidarConfig()).beam_rad
        self._memory = CellMemory(CELL_M)
        self._time = self._searched = -math.inf
        self._search = True

    def forget(self, time: float, points_odom: Floats, ego_odom: npt.ArrayLike = EGO) -> None:
        """Begin a scan: weaken the cells that its beams pass, and all cells with time.

        Parameters
        ----------
        time
            Of the scan [s].
        points_odom
            (N, 2) all of its points [m], also on the ground and on the ego.
        ego_odom
            (2,) centre of the ego [m].
        """
        memory = self._memory
        self._search = time - self._searched >= SEARCH_INTERVAL_S
        self._searched = time if self._search else self._searched
        if time - self._time < PASSED_INTERVAL_S:
            return
        factor = elementary.exp(-(time - self._time) / self._config.memory_s)
        self._time = time
        if not len(memory.cells):
            return
        ego = np.asarray(ego_odom)
        free = free_space.free(memory.centers() - ego, points_odom - ego, 2.0 * CELL_M)
        memory.weaken(np.where(free, PASSED_LOG_ODDS, 0.0), factor, LOG_ODDS_MIN)

    def remove(self, points_odom: Floats, segments: Segments, ego_odom: npt.ArrayLike = EGO) -> Segments:
        """Return the segments of points (N, 2) [m] without walls, which are stored.

        Segments that are too long for a vehicle are split into walls and vehicles; the latter are numbered last.
        """
        order = np.flatnonzero(segments.label != NOT_USED)
        if not len(order):
            return segments
        points, label = points_odom.take(order, axis=0), segments.label[order]
        cells = self._memory.cell(points)
        known = self._memory.contains(cells)
        long = extents(points, label) > self._config.length_min_m
        own = np.flatnonzero(long[label])
        if len(own):
            known[own], part = self._split(points[own] - np.asarray(ego_odom), label[own], cells[own], known[own])
            label[own] = np.where(part == NOT_USED, NOT_USED, part + segments.count)
        whole = np.full(len(segments.label), NOT_USED)
        whole[order] = label
        count = int(label.max()) + 1
        used = label != NOT_USED
        size, on_wall = (np.bincount(label[used], weights, count) for weights in (None, known[used]))
        return keep_only(Segments(whole, count), (size > 0) & (on_wall <= KNOWN_FRACTION_MAX * size))

    def _split(self, points: Floats, segment: Ints, cells: Ints, known: Bools) -> tuple[Bools, Ints]:
        """Split long segments as `walls.split` does, and store the cells (P,) of the walls.

        A search that includes remembered walls weakens the cells where it finds something else.
        """
        remembered = known & (not self._search)
        wall, part = split(points, segment, remembered, self._config.length_min_m, self._beam_rad, self._segmentation)
        found = np.unique(cells[wall & ~remembered])
        self._memory.strengthen(found, HIT_LOG_ODDS, LOG_ODDS_MAX)
        if self._search:
            refuted = np.isin(self._memory.cells, np.setdiff1d(cells[~wall], found))
            loss = np.where(refuted, HIT_LOG_ODDS, 0.0)
            self._memory.weaken(loss, 1.0, LOG_ODDS_MIN)
        return wall | self._memory.contains(cells), part


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


@kernel()
def contained(cells: Ints, known: Ints) -> Bools:
    """(N,) mask of the cells that are among the sorted `known` ones; a search serves all equal cells that follow."""
    found = np.zeros(len(cells), np.bool_)
    for i in range(len(cells)):
        if i > 0 and cells[i] == cells[i - 1]:
            found[i] = found[i - 1]
        else:
            place, end = 0, len(known)  # bisection: numpy's takes half a second to compile
            while place < end:
                middle = (place + end) // 2
                if known[middle] < cells[i]:
                    place = middle + 1
                else:
                    end = middle
            found[i] = place < len(known) and known[place] == cells[i]
    return found

"""Background model: cells where an object too long for a vehicle was seen.

A wall is recognised by its length while most of it is visible. When traffic occludes parts of it, the rest may have the
size of a truck. Cells that a wall once covered are therefore stored, in the odometry frame.
"""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.detection.segmentation import by_segment, keep_only
from tracker.records import Segments


@dataclass(frozen=True, slots=True)
class BackgroundConfig:
    """Memory of walls."""

    length_min_m: float = 20.0
    """Segments longer than this are background [m]; an articulated bus measures 17.9."""
    cell_m: float = 0.5
    """Size of a cell [m]."""
    share_max: float = 0.5
    """A segment with a larger share of its points in background cells is background."""

    def __post_init__(self) -> None:
        if self.length_min_m <= 0 or self.cell_m <= 0:
            raise ValueError("length_min_m and cell_m must be above 0")


class Background:
    """Sorted set of background cells."""

    def __init__(self, config: BackgroundConfig) -> None:
        self._config = config
        self._cells: Ints = np.empty(0, dtype=np.int64)

    def remove(self, points_odom: Floats, segments: Segments) -> Segments:
        """Add the walls among segments of points (N, 2) [m], and return the segments that are not background."""
        order, offset = by_segment(segments)
        if not len(order):
            return segments
        label, points = segments.label[order], points_odom[order]
        cells = self._cell(points)
        wall = extent(points, offset) > self._config.length_min_m
        self._add(np.unique(cells[wall[label]]))
        on_wall = np.add.reduceat(self._contains(cells).astype(np.int64), offset[:-1])
        return keep_only(segments, on_wall <= self._config.share_max * np.diff(offset))

    def _add(self, cells: Ints) -> None:
        """Insert sorted cells (N,)."""
        new = cells[~self._contains(cells)]
        self._cells = np.insert(self._cells, np.searchsorted(self._cells, new), new)

    def _contains(self, cells: Ints) -> Bools:
        """(N,) mask of cells in the set; a binary search, because a long drive adds very many."""
        place = np.searchsorted(self._cells, cells)
        known = np.zeros(len(cells), np.bool_)
        inside = place < len(self._cells)
        known[inside] = self._cells[place[inside]] == cells[inside]
        return known

    def _cell(self, points_odom: Floats) -> Ints:
        """(N,) cell number of each point: column in the high half, row in the low half."""
        column, row = np.floor(points_odom / self._config.cell_m).astype(np.int64).T
        return np.asarray((column << 32) + row)


def extent(points: Floats, offset: Ints) -> Floats:
    """(S,) largest extent of each segment of points (N, 2) over directions 22.5 degrees apart [m].

    At most 2 % below the diameter of the segment.
    """
    angle = np.arange(0.0, np.pi, np.pi / 8)
    along = points @ np.array([np.cos(angle), np.sin(angle)])
    low, high = np.minimum.reduceat(along, offset[:-1]), np.maximum.reduceat(along, offset[:-1])
    return np.asarray(np.max(high - low, axis=1))

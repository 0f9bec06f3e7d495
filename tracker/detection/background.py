"""What stands for good: places where something too long for any vehicle was seen.

A wall is easy to tell while most of it is in view. Once traffic hides parts of it, what is left may have the size of
a truck. Cells that a wall once covered are therefore remembered, in the odometry frame.
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
    """Segments longer than this are no vehicles [m]; a bendy bus measures 17.9."""
    cell_m: float = 0.5
    """Pitch of the memory [m]."""
    share_max: float = 0.5
    """A segment with more of its points than this in remembered cells belongs to the background."""

    def __post_init__(self) -> None:
        if self.length_min_m <= 0 or self.cell_m <= 0:
            raise ValueError("length_min_m and cell_m must be above 0")


class Background:
    """The remembered cells."""

    def __init__(self, config: BackgroundConfig) -> None:
        self._config = config
        self._cells: Ints = np.empty(0, dtype=np.int64)

    def remove(self, points_odom: Floats, segments: Segments) -> Segments:
        """Remember the walls among segments of points (N, 2) [m], and drop all segments that lie on walls."""
        order, offset = by_segment(segments)
        if not len(order):
            return segments
        label, points = segments.label[order], points_odom[order]
        cells = self._cell(points)
        wall = extent(points, offset) > self._config.length_min_m
        self._remember(np.unique(cells[wall[label]]))
        on_wall = np.add.reduceat(self._knows(cells).astype(np.int64), offset[:-1])
        return keep_only(segments, on_wall <= self._config.share_max * np.diff(offset))

    def _remember(self, cells: Ints) -> None:
        """Add sorted cells (N,) to those that are remembered, which stay sorted."""
        new = cells[~self._knows(cells)]
        self._cells = np.insert(self._cells, np.searchsorted(self._cells, new), new)

    def _knows(self, cells: Ints) -> Bools:
        """Whether cells (N,) are remembered; looked up, since a long drive remembers very many."""
        place = np.searchsorted(self._cells, cells)
        known = np.zeros(len(cells), np.bool_)
        inside = place < len(self._cells)
        known[inside] = self._cells[place[inside]] == cells[inside]
        return known

    def _cell(self, points_odom: Floats) -> Ints:
        """(N,) one number per cell; row and column share its halves."""
        column, row = np.floor(points_odom / self._config.cell_m).astype(np.int64).T
        return np.asarray((column << 32) + row)


def extent(points: Floats, offset: Ints) -> Floats:
    """(S,) longest extent of each segment of points (N, 2) over directions 22.5 degrees apart [m].

    No more than 2 % short of the segment's diameter.
    """
    angle = np.arange(0.0, np.pi, np.pi / 8)
    along = points @ np.array([np.cos(angle), np.sin(angle)])
    low, high = np.minimum.reduceat(along, offset[:-1]), np.maximum.reduceat(along, offset[:-1])
    return np.asarray(np.max(high - low, axis=1))

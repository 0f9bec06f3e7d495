"""What stands for good: places where something too long for any vehicle was seen.

A wall is easy to tell while most of it is in view. Once traffic hides parts of it, what is left may have the size of
a truck. Cells that a wall once covered are therefore remembered, in the odometry frame.
"""

from dataclasses import dataclass

import numpy as np

from tracker.records import Bools, Floats, Ints, Segments


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

    def step(self, points_odom: Floats, segments: Segments, length: Floats) -> Bools:
        """Remember the walls among S segments and tell which segments belong to the background.

        Parameters
        ----------
        points_odom
            (N, 2) [m].
        length
            (S,) longer side of each segment's rectangle [m].

        Returns
        -------
        (S,) whether a segment is background.
        """
        used = np.flatnonzero(segments.label >= 0)
        label = segments.label[used]
        cells = self._cell(points_odom[used])
        wall = length > self._config.length_min_m
        self._cells = np.union1d(self._cells, cells[wall[label]])
        known = np.isin(cells, self._cells)
        on_wall = np.bincount(label[known], minlength=segments.count)
        of = np.bincount(label, minlength=segments.count)
        return np.asarray(on_wall > self._config.share_max * of)

    def _cell(self, points_odom: Floats) -> Ints:
        """(N,) one number per cell; row and column share its halves."""
        column, row = np.floor(points_odom / self._config.cell_m).astype(np.int64).T
        return np.asarray((column << 32) + row)

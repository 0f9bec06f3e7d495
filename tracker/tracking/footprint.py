"""Area covered by the visible part of a track."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats
from tracker.geometry import projected_size, rotate_one

LEFT_MARGIN_M = 1.5
"""Clearance of a vehicle that left a place [m]: the position of a small piece of wall along the wall is this
uncertain."""


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """Rectangle covered by the visible part of a track, odometry frame."""

    center: Floats
    """(2,) centre of the visible part [m]."""
    heading: float
    """[rad]."""
    size: Floats
    """(2,) extent of the visible part along and across the heading [m]."""

    def clear_of(self, other: "Footprint") -> Bools:
        """(2,) mask of the axes, along and across this heading, on which the two footprints do not overlap.

        The speed of a filter does not show that an object moved: while more and more of a wall comes into view, its
        centre moves like that of a vehicle, but it always overlaps its first footprint.
        """
        away = np.abs(rotate_one(self.center - other.center, -self.heading))
        taken = self.size + projected_size(other.size, other.heading - self.heading)
        return np.asarray(away > 0.5 * taken + LEFT_MARGIN_M)

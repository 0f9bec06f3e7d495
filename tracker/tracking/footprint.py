"""Where a thing is, as far as it was seen; and whether it has left its place."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats
from tracker.geometry import reach, rotate

LEFT_MARGIN_M = 1.5
"""Of a vehicle that left its place: small pieces of a wall are known no better along it [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """Where a thing is, as far as it was seen."""

    center: Floats
    """(2,) middle of what was seen [m]."""
    heading: float
    """[rad]."""
    size: Floats
    """(2,) extent of what was seen along and across the heading [m]."""

    def clear_of(self, other: "Footprint") -> Bools:
        """(2,) whether the two have nothing in common along and across this one's heading.

        The speed of a filter does not tell whether a thing moved: of a wall more and more comes into view, and its
        middle moves as a vehicle's would, but it never leaves the place where it was first seen.
        """
        away = np.abs(rotate(self.center - other.center, -self.heading))
        taken = self.size + reach(other.size, other.heading - self.heading)
        return np.asarray(away > 0.5 * taken + LEFT_MARGIN_M)

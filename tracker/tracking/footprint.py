"""Area covered by the visible part of a track."""

import cmath
from dataclasses import dataclass

from luxloop.tracker.arrays import Floats

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

    def clear_of(self, other: "Footprint") -> tuple[bool, bool]:
        """Flags of the axes, along and across this heading, on which the two footprints do not overlap.

        The speed of a filter does not show that an object moved: while more and more of a wall comes into view, its
        centre moves like that of a vehicle, but it always overlaps its first footprint.
        """
        (length, width), (other_length, other_width) = self.size.tolist(), other.size.tolist()
        away = complex(*(self.center - other.center).tolist()) * cmath.rect(1.0, -self.heading)
        turn = cmath.rect(1.0, other.heading - self.heading)
        cos, sin = abs(turn.real), abs(turn.imag)
        along = 0.5 * (length + cos * other_length + sin * other_width)
        across = 0.5 * (width + sin * other_length + cos * other_width)
        return abs(away.real) > along + LEFT_MARGIN_M, abs(away.imag) > across + LEFT_MARGIN_M

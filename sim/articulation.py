"""Where an articulated truck bends: one place for the sensor, which turns the tractor, and for its motion.

Measures of the usual European combination, 16.5 m long in all: its semitrailer measures 13.6 m and reaches at most
12.0 m behind the kingpin (Directive 96/53/EC, annex I, 1.6), so 1.6 m before it, and no corner of its front is more
than 2.04 m away (4.4 there): it clears the cab at any angle. Two-axle tractors have wheelbases around 3.7 m, front
overhangs around 1.4 m, and the coupling some 0.6 m ahead of the drive axle. The trailer's three axles, 1.31 m apart,
lie around 7.7 m behind the kingpin.
"""

from typing import NamedTuple

import numpy as np

from sim.arrays import Floats

SHORTEST_M, LONGEST_M = 13.5, 19.0
"""Between these, tractors are alike and trailers differ in length. Any other vehicle is the nearest one, scaled."""
WHEELBASE_M = 3.7
"""Of the tractor."""
AXLE_SPACING_M = 1.31
"""Of the trailer."""
_FRONT_OVERHANG_M = 1.4
"""Of the tractor."""
_KINGPIN_AHEAD_M = 0.6
"""Of the drive axle."""
_TRAILER_AHEAD_M = 1.6
"""Of the kingpin."""
_AXLES_TO_REAR_M = 4.3
"""From the middle of the trailer's axles."""


class Hitch(NamedTuple):
    """Places of N articulated vehicles, straight: how far each is behind the front bumper [m]."""

    trailer_front: Floats
    """(N,)"""
    kingpin: Floats
    """(N,) about which tractor and trailer turn."""
    drive_axle: Floats
    """(N,) the tractor's rear axle, a little behind the kingpin."""
    trailer_axles: Floats
    """(N,) their middle."""


def hitch(length: Floats) -> Hitch:
    """Say where vehicles of these overall lengths (N,) [m] couple and roll."""
    usual = np.clip(length, SHORTEST_M, LONGEST_M)
    scale = length / usual
    drive_axle = _FRONT_OVERHANG_M + WHEELBASE_M
    kingpin = drive_axle - _KINGPIN_AHEAD_M
    return Hitch(
        trailer_front=scale * (kingpin - _TRAILER_AHEAD_M),
        kingpin=scale * kingpin,
        drive_axle=scale * drive_axle,
        trailer_axles=scale * (usual - _AXLES_TO_REAR_M),
    )

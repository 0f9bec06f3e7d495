"""Geometry of articulated trucks, shared by the sensor, which turns the tractor, and the truth layer.

Dimensions of the common European combination, 16.5 m long: the semitrailer is 13.6 m long and reaches at most 12.0 m
behind the kingpin (Directive 96/53/EC, annex I, 1.6), hence 1.6 m ahead of it. No corner of its front is more than
2.04 m from the kingpin (4.4 there), so it clears the cab at any angle. Two-axle tractors have wheelbases of about
3.7 m, front overhangs of about 1.4 m, and the coupling about 0.6 m ahead of the drive axle. The trailer's three axles,
1.31 m apart, are about 7.7 m behind the kingpin.
"""

from typing import NamedTuple

import numpy as np

from sim.arrays import Floats

SHORTEST_M, LONGEST_M = 13.5, 19.0
"""[m] Overall lengths. Within this range the tractor is constant and the trailer varies; beyond it, all is scaled."""
WHEELBASE_M = 3.7
"""[m] Wheelbase of the tractor."""
AXLE_SPACING_M = 1.31
"""[m] Distance between the trailer's axles."""
_FRONT_OVERHANG_M = 1.4
"""[m] Front overhang of the tractor."""
_KINGPIN_AHEAD_M = 0.6
"""[m] Kingpin ahead of the drive axle."""
_TRAILER_AHEAD_M = 1.6
"""[m] Front of the trailer ahead of the kingpin."""
_AXLES_TO_REAR_M = 4.3
"""[m] From the middle of the trailer's axles to its rear."""


class Hitch(NamedTuple):
    """Positions along N straight articulated vehicles: distance behind the front bumper [m]."""

    trailer_front: Floats
    """(N,)"""
    kingpin: Floats
    """(N,) pivot between tractor and trailer."""
    drive_axle: Floats
    """(N,) the tractor's rear axle, slightly behind the kingpin."""
    trailer_axles: Floats
    """(N,) middle of the trailer's axles."""


def hitch(length: Floats) -> Hitch:
    """Return the positions of coupling and axles of vehicles with overall lengths (N,) [m]."""
    clipped = np.clip(length, SHORTEST_M, LONGEST_M)
    scale = length / clipped
    drive_axle = _FRONT_OVERHANG_M + WHEELBASE_M
    kingpin = drive_axle - _KINGPIN_AHEAD_M
    return Hitch(
        trailer_front=scale * (kingpin - _TRAILER_AHEAD_M),
        kingpin=scale * kingpin,
        drive_axle=scale * drive_axle,
        trailer_axles=scale * (clipped - _AXLES_TO_REAR_M),
    )

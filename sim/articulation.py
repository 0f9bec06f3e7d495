"""Geometry of articulated trucks and buses, shared by the sensor, which turns the front part, and the truth layer.

Trucks have the dimensions of the common European combination, 16.5 m long: the semitrailer is 13.6 m long and reaches
at most 12.0 m behind the kingpin (Directive 96/53/EC, annex I, 1.6), hence 1.6 m ahead of it. No corner of its front
is more than 2.04 m from the kingpin (4.4 there), so it clears the cab at any angle. Two-axle tractors have wheelbases
of about 3.7 m, front overhangs of about 1.4 m, and the coupling about 0.6 m ahead of the drive axle. The trailer's
three axles, 1.31 m apart, are about 7.7 m behind the kingpin.

Buses of more than 15.00 m and up to 18.75 m are articulated: rigid ones may not be longer, articulated ones neither
(Directive 96/53/EC as amended by 2002/7/EC, annex I, 1.1). They are pushers with a joint behind the middle axle and one
axle in the rear part. Front part and rear part correspond to a truck's tractor and trailer.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats
from luxloop.sim.world import Kind

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

LONGEST_RIGID_BUS_M, LONGEST_BUS_M = 15.0, 18.75
"""[m] Overall lengths; longer bodies of the kind are trams and trains, see `luxloop.sim.sections`."""
_BUS_M = 18.125
"""[m] Overall length of the dimensions below, which scale with it: front overhang 2.805, wheelbases 5.900 and 5.990,
rear overhang 3.430 (Mercedes-Benz Citaro G, technical data)."""
_BUS_MIDDLE_AXLE_M, _BUS_REAR_AXLE_M = 2.805 + 5.900, 2.805 + 5.900 + 5.990
"""[m] Behind the front bumper."""
_BUS_JOINT_M = _BUS_MIDDLE_AXLE_M + 1.75
"""[m] The distance from the middle axle is an estimate. With it the bus just stays within the swept ring of 5.30 to
12.50 m that Directive 96/53/EC, annex I, 1.5 requires."""


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


def is_articulated(kind: npt.NDArray[np.uint8], length: Floats) -> Bools:
    """Return the mask (N,) of vehicles with a joint, by `Kind` and overall length [m]."""
    long = (length > LONGEST_RIGID_BUS_M) & (length <= LONGEST_BUS_M)
    articulated: Bools = (kind == Kind.TRAILER_TRUCK) | ((kind == Kind.BUS) & long)
    return articulated


def hitch(length: Floats, kind: npt.NDArray[np.uint8] | None = None) -> Hitch:
    """Return the positions of coupling and axles of articulated vehicles.

    Parameters
    ----------
    length
        (N,) overall lengths [m].
    kind
        (N,) `Kind`: buses, and trucks for all others. Default: trucks.
    """
    trucks = _truck_hitch(length)
    if kind is None:
        return trucks
    scale = length / _BUS_M
    bus = Hitch(scale * _BUS_JOINT_M, scale * _BUS_JOINT_M, scale * _BUS_MIDDLE_AXLE_M, scale * _BUS_REAR_AXLE_M)
    chosen = (np.where(kind == Kind.BUS, *places) for places in zip(bus, trucks, strict=True))
    return Hitch(*chosen)


def _truck_hitch(length: Floats) -> Hitch:
    """Return the positions of trucks with overall lengths (N,) [m]."""
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

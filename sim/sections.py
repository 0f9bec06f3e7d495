"""Rigid sections of vehicles with joints, from the front: tractor and trailer, parts of a bus, cars of a tram or train.

Bodies of `Kind.BUS` that are longer than any bus are trams, or trains if they are longer than 75 m, the limit on
streets (Germany's BOStrab, section 55). They consist of equal sections. SUMO draws them with sections of 5.71 m (tram,
after the Bombardier Flexity Berlin) and 18.4 m (urban train, after DB's class 481; `SUMOVTypeParameter.cpp`). The
number of sections here is the length over these, rounded: 5 of 30.8 m and 7 of 40.05 m, as those trams have.

The pose of a vehicle is that of its straight box, aligned with its middle section, of two the rear one.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.sim.articulation import LONGEST_BUS_M, hitch, is_articulated
from luxloop.sim.world import JOINTS, Kind

LONGEST_TRAM_M = 75.0
"""[m] Longer bodies of the kind are trains."""
_TRAM_SECTION_M, _TRAIN_SECTION_M = 5.71, 18.4

Kinds = npt.NDArray[np.uint8]
"""`Kind` of each vehicle."""


class Sections(NamedTuple):
    """Sections of N straight vehicles; S = JOINTS + 1. Positions are distances behind the front bumper [m].

    The last section of a vehicle is repeated without length.
    """

    middle: Ints
    """(N,) the section that is aligned with the pose."""
    joint: Floats
    """(N, JOINTS) joints between sections j and j + 1."""
    front: Floats
    """(N, S) front end of each section's box."""
    rear: Floats
    """(N, S)"""


class SectionMoves(NamedTuple):
    """Motion of S sections of N vehicles from the straight to the bent body, in the frame of the body.

    A point p moves to `moved` + R(`turn`) (p - (`pivot`, 0)).
    """

    turn: Floats
    """(N, S) [rad], counter-clockwise."""
    pivot: Floats
    """(N, S) x of a joint on the axis of the straight body [m]."""
    moved: Floats
    """(N, S, 2) the joint in the bent body [m]."""


def is_on_rails(kind: Kinds, length: Floats) -> Bools:
    """Return the mask (N,) of trams and trains, by `Kind` and overall length [m]."""
    on_rails: Bools = (kind == Kind.BUS) & (length > LONGEST_BUS_M)
    return on_rails


def section_count(kind: Kinds, length: Floats) -> Ints:
    """Return the number (N,) of sections, by `Kind` and overall length [m]; 1 for rigid bodies."""
    typical = np.where(length > LONGEST_TRAM_M, _TRAIN_SECTION_M, _TRAM_SECTION_M)
    cars = np.clip(np.rint(length / typical), 2, JOINTS + 1).astype(np.int64)
    return np.where(is_on_rails(kind, length), cars, np.where(is_articulated(kind, length), 2, 1))


def sections(kind: Kinds, length: Floats) -> Sections:
    """Return the sections of N vehicles, by `Kind` and overall length [m]."""
    count = section_count(kind, length)[:, None]
    whole = length[:, None]
    joint = np.minimum(np.arange(1, JOINTS + 1) / count, 1.0) * whole
    ends = joint.copy()
    coupled = np.flatnonzero(is_articulated(kind, length))
    coupling = hitch(length[coupled], kind[coupled])
    joint[coupled, 0], ends[coupled, 0] = coupling.kingpin, coupling.trailer_front
    start = np.zeros((len(length), 1))
    return Sections(count[:, 0] // 2, joint, np.hstack([start, ends]), np.hstack([ends, whole]))


def section_moves(straight: Sections, length: Floats, angles: Floats) -> SectionMoves:
    """Return the motion of the sections of N vehicles with joints.

    Parameters
    ----------
    straight
        Their sections.
    length
        (N,) overall length [m].
    angles
        (N, JOINTS) yaw of section j relative to section j + 1 [rad].
    """
    middle, joint, _, _ = straight
    row = np.arange(len(length))
    bent = np.hstack([np.zeros((len(length), 1)), np.cumsum(angles, axis=1)])
    turn = bent[row, middle][:, None] - bent
    x = 0.5 * length[:, None] - joint
    # From joint to joint along the sections between; all are moved so that the front joint of the middle section stays.
    along = np.diff(x, axis=1)[..., None] * np.stack(
        [elementwise.cos(turn[:, 1:-1]), elementwise.sin(turn[:, 1:-1])], axis=-1
    )
    place = np.concatenate([np.zeros((len(length), 1, 2)), np.cumsum(along, axis=1)], axis=1)
    place -= place[row, middle - 1][:, None]
    place[..., 0] += x[row, middle - 1][:, None]
    section = np.arange(JOINTS + 1)
    pivot = np.where(section < middle[:, None], section, section - 1)
    return SectionMoves(turn, np.take_along_axis(x, pivot, axis=1), place[row[:, None], pivot])


def bend(angles: Floats) -> Floats:
    """Return the largest angle (N,) [rad] between two sections, from angles (N, J) at the joints."""
    yaw = np.cumsum(np.pad(angles, ((0, 0), (1, 0))), axis=1)
    return np.asarray(np.ptp(yaw, axis=1))

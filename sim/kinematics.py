"""How bodies move: the records between a simulator and the world record."""

from dataclasses import dataclass

import numpy as np

from sim.arrays import Bools, Floats
from sim.roster import Member


def wrap_angle(angle: Floats) -> Floats:
    """Bring angles [rad] into (-pi, pi]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


@dataclass(frozen=True, slots=True, eq=False)
class RawFrame:
    """What a simulator says of one instant: N road users, the ego first, the others by ascending number."""

    members: list[Member]
    pose_world: Floats
    """(N, 3) box centre x [m], y [m], yaw [rad]; not yet a motion that a body could make."""
    speed: Floats
    """(N,) the simulator's own [m/s]; negative backwards."""


@dataclass(frozen=True, slots=True, eq=False)
class Kinematics:
    """The motion of N bodies at one instant. Rates are those of the motion that the poses follow."""

    pose_world: Floats
    """(N, 3) box centre x [m], y [m], yaw [rad] in (-pi, pi]."""
    velocity_world: Floats
    """(N, 2) [m/s], of the box centre."""
    acceleration_world: Floats
    """(N, 2) [m/s^2], of the box centre."""
    yaw_rate: Floats
    """(N,) [rad/s], counter-clockwise positive."""
    articulation: Floats
    """(N,) [rad] see `sim.world.Actors`."""
    changes_lane: Bools
    """(N,) see `sim.world.Actors`."""
    deviation: Floats
    """(N, 2) [m] see `sim.world.Actors`."""

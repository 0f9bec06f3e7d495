"""Records of motion between a simulator and the world record, and the origin of the world frame."""

from dataclasses import dataclass, field

import numpy as np

from luxloop.arrays import Bools, Floats
from luxloop.sim.roster import Member
from luxloop.sim.world import JOINTS, Collision, no_angles


def wrap_angle(angle: Floats) -> Floats:
    """Wrap angles [rad] into (-pi, pi]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


@dataclass(frozen=True, slots=True, eq=False)
class RawFrame:
    """Simulator output of one instant: N road users, the ego first, the others by ascending number."""

    members: list[Member]
    pose_world: Floats
    """(N, 3) box centre x [m], y [m], yaw [rad]; not yet physically feasible."""
    speed: Floats
    """(N,) the simulator's speed [m/s]; negative when reversing."""
    road: Floats | None = None
    """(N, 2) height of the road under the pose [m] and its slope along the body [rad], positive uphill, in the
    simulator; None if it has no heights, NaN where it has none. Used on bridges only, see `sim.frame_builder`."""
    collisions: tuple[Collision, ...] = ()
    """See `luxloop.sim.world.WorldFrame`."""


@dataclass(frozen=True, slots=True, eq=False)
class Kinematics:
    """Motion of N bodies at one instant. Rates are the exact derivatives of the motion that the poses sample."""

    pose_world: Floats
    """(N, 3) box centre x [m], y [m], yaw [rad] in (-pi, pi]."""
    velocity_world: Floats
    """(N, 2) [m/s], of the box centre."""
    acceleration_world: Floats
    """(N, 2) [m/s^2], of the box centre."""
    yaw_rate: Floats
    """(N,) [rad/s], counter-clockwise positive."""
    articulation: Floats
    """(N,) [rad] see `luxloop.sim.world.Actors`."""
    changes_lane: Bools
    """(N,) see `luxloop.sim.world.Actors`."""
    deviation: Floats
    """(N, 2) [m] see `luxloop.sim.world.Actors`."""
    road: Floats | None = None
    """(N, 2) see `RawFrame`."""
    further_articulation: Floats = field(default_factory=no_angles)
    """(N, JOINTS - 1) [rad] see `luxloop.sim.world.Actors`."""
    collisions: tuple[Collision, ...] = ()
    """See `luxloop.sim.world.WorldFrame`."""

    def __post_init__(self) -> None:
        if not len(self.further_articulation):
            object.__setattr__(self, "further_articulation", np.zeros((len(self.articulation), JOINTS - 1)))

    @property
    def joint_angles(self) -> Floats:
        """(N, JOINTS) [rad] see `luxloop.sim.world.Actors`."""
        return np.column_stack([self.articulation, self.further_articulation])


STEP_M = 10_000.0
"""[m] Grid of possible origins: round numbers keep coordinates recognisable; small maps keep the origin (0, 0)."""


def origin_near(place: Floats) -> Floats:
    """Return the multiple (2,) of `STEP_M` nearest to the ego's first position (2,), in simulator coordinates [m]."""
    return np.round(place / STEP_M) * STEP_M + 0.0  # adding 0.0 turns -0 into 0

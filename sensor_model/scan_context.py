"""The circumstances of one sweep: where the units really are, how the ego moves, and how sensitive each beam is."""

from dataclasses import dataclass

import numpy as np

from sensor_model.arrays import Floats
from sensor_model.bodies.scene import Bodies
from sensor_model.kernels.records import EgoDrive
from sensor_model.returns import Returns
from sensor_model.rig.beams import BeamTable
from sim.world import Ego


@dataclass(frozen=True, slots=True, eq=False)
class ScanContext:
    """Of U units and B beams. The ego frame is level: what is here is over ground, whatever the ego believes."""

    frame_index: int
    """Decides which mirror side fires."""
    origin_ego: Floats
    """(U, 3) where each unit really is at the frame's time [m]."""
    R_ego_unit: Floats
    """(U, 3, 3) its rotation: ego = R unit."""
    time_jitter: Floats
    """(U,) how much later than nominal each unit fires [s]."""
    ego_velocity: Floats
    """(2,) over ground, in the ego frame [m/s]."""
    ego_acceleration: Floats
    """(2,) likewise [m/s^2]."""
    ego_yaw_rate: float
    """[rad/s]"""
    threshold: Floats
    """(B,) power that makes an echo, infinite for a beam that cannot have one [1/m^2]."""
    extinction: float = 0.0
    """Of the air [1/m]."""

    @property
    def drive(self) -> EgoDrive:
        """The ego's motion, as the kernels take it."""
        (vx, vy), (ax, ay) = self.ego_velocity, self.ego_acceleration
        return EgoDrive(vx, vy, ax, ay, self.ego_yaw_rate)


def over_ground(ego: Ego) -> tuple[Floats, Floats, float]:
    """Velocity (2,) and acceleration (2,) of the ego in its own frame, and yaw rate, over ground."""
    cos, sin = np.cos(ego.pose_world[2]), np.sin(ego.pose_world[2])
    R_ego_world = np.array([[cos, sin], [-sin, cos]])
    return R_ego_world @ ego.velocity_world, R_ego_world @ ego.acceleration_world, ego.yaw_rate


def displacement(
    returns: Returns, beams: BeamTable, mounts: tuple[Floats, Floats], bodies: Bodies, setting: ScanContext
) -> Floats:
    """(N,) how far each point is put from where exact mounts and firing times would put it [m].

    Parameters
    ----------
    mounts
        True origins (U, 3) and rotations (U, 3, 3) of the units in the ego's body.
    """
    units, unit = beams.units, beams.unit[returns.beam]
    origin, R_body_unit = mounts
    R_nominal_true = R_body_unit @ units.R_ego_unit.transpose(0, 2, 1)
    direction = beams.direction_ego[returns.beam]
    turned = np.einsum("nij,nj->ni", R_nominal_true[unit], direction) - direction
    moved = (origin - units.origin_ego)[unit] + returns.range[:, None] * turned
    on_actor = np.flatnonzero(returns.target >= 0)
    actor = returns.target[on_actor]
    point = (units.origin_ego[unit] + returns.range[:, None] * direction)[on_actor, :2]
    passed = bodies.velocity_ego[actor] - setting.ego_velocity
    passed += bodies.yaw_rate[actor, None] * _turned_left(point - bodies.pose_ego[actor, :2])
    passed -= setting.ego_yaw_rate * _turned_left(point)
    moved[on_actor, :2] += setting.time_jitter[unit[on_actor], None] * passed
    distance: Floats = np.linalg.norm(moved, axis=1)
    return distance


def _turned_left(vector: Floats) -> Floats:
    """(N, 2) vectors turned by 90 degrees: how points there move at a yaw rate of 1."""
    return np.stack([-vector[:, 1], vector[:, 0]], axis=1)

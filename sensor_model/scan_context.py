"""Context of one scan: true poses of the units, ego motion, and detection thresholds."""

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
    """Context of a scan of U units with B beams. The ego frame is level; all values are ground truth."""

    frame_index: int
    """Index of the frame, which decides the mirror face that fires."""
    origin_ego: Floats
    """(U, 3) true position of each unit at the frame's time [m]."""
    R_ego_unit: Floats
    """(U, 3, 3) true rotation of each unit: ego = R unit."""
    time_jitter: Floats
    """(U,) delay of each unit's firing times relative to the nominal ones [s]."""
    ego_velocity: Floats
    """(2,) over ground, in the ego frame [m/s]."""
    ego_acceleration: Floats
    """(2,) over ground, in the ego frame [m/s^2]."""
    ego_yaw_rate: float
    """[rad/s]"""
    threshold: Floats
    """(B,) minimum power of an echo, infinite for a blind beam [1/m^2]."""
    extinction: float = 0.0
    """Extinction coefficient of the air [1/m]."""

    @property
    def drive(self) -> EgoDrive:
        """Ego motion as a record for the kernels."""
        (vx, vy), (ax, ay) = self.ego_velocity, self.ego_acceleration
        return EgoDrive(vx, vy, ax, ay, self.ego_yaw_rate)


def over_ground(ego: Ego) -> tuple[Floats, Floats, float]:
    """Return velocity (2,) and acceleration (2,) of the ego in the ego frame, and yaw rate, all over ground."""
    cos, sin = np.cos(ego.pose_world[2]), np.sin(ego.pose_world[2])
    R_ego_world = np.array([[cos, sin], [-sin, cos]])
    return R_ego_world @ ego.velocity_world, R_ego_world @ ego.acceleration_world, ego.yaw_rate


def displacement(
    returns: Returns, beams: BeamTable, mounts: tuple[Floats, Floats], bodies: Bodies, context: ScanContext
) -> Floats:
    """Return the (N,) displacement of each point by the errors of mounting poses and firing times [m].

    Parameters
    ----------
    mounts
        True origins (U, 3) and rotations (U, 3, 3) of the units in the frame of the ego's body.
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
    passed = bodies.velocity_ego[actor] - context.ego_velocity
    passed += bodies.yaw_rate[actor, None] * _rotated_left(point - bodies.pose_ego[actor, :2])
    passed -= context.ego_yaw_rate * _rotated_left(point)
    moved[on_actor, :2] += context.time_jitter[unit[on_actor], None] * passed
    distance: Floats = np.linalg.norm(moved, axis=1)
    return distance


def _rotated_left(vector: Floats) -> Floats:
    """Rotate vectors (N, 2) by 90 degrees: the velocities of these points at a yaw rate of 1."""
    return np.stack([-vector[:, 1], vector[:, 0]], axis=1)

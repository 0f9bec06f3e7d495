"""Context of one scan: true poses of the units, ego motion, and detection thresholds."""

from dataclasses import dataclass

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sensor_model.bodies.scene import Bodies
from luxloop.sensor_model.ground import FLAT
from luxloop.sensor_model.kernels.point_shift import calibration_shift
from luxloop.sensor_model.kernels.records import EgoDrive, Ground, MountErrors
from luxloop.sensor_model.returns import Returns
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sim.world import Ego


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
    ground: Ground = FLAT
    """Ground around the ego."""

    @property
    def drive(self) -> EgoDrive:
        """Ego motion as a record for the kernels."""
        (vx, vy), (ax, ay) = self.ego_velocity, self.ego_acceleration
        return EgoDrive(vx, vy, ax, ay, self.ego_yaw_rate)


def over_ground(ego: Ego) -> tuple[Floats, Floats, float]:
    """Return velocity (2,) and acceleration (2,) of the ego in the ego frame, and yaw rate, all over ground."""
    cos, sin = elementary.cos(ego.pose_world[2]), elementary.sin(ego.pose_world[2])
    R_ego_world = np.array([[cos, sin], [-sin, cos]])
    return (
        elementwise.product(R_ego_world, ego.velocity_world),
        elementwise.product(R_ego_world, ego.acceleration_world),
        ego.yaw_rate,
    )


def displacement(
    returns: Returns, beams: BeamTable, mounts: tuple[Floats, Floats], bodies: Bodies, context: ScanContext
) -> Floats:
    """Return the (N,) displacement of each point on an actor by the errors of mounting poses and firing times [m].

    It is 0 for other points.

    Parameters
    ----------
    mounts
        True origins (U, 3) and rotations (U, 3, 3) of the units in the frame of the ego's body.
    """
    units, (origin, R_body_unit) = beams.units, mounts
    R_nominal_true = elementwise.product(R_body_unit, units.R_ego_unit.transpose(0, 2, 1))
    errors = MountErrors(units.origin_ego, origin - units.origin_ego, R_nominal_true, context.time_jitter)
    shift: Floats = calibration_shift(
        returns.beam, returns.range, returns.target, beams.unit, beams.direction_ego, errors, bodies.motion,
        context.ego_velocity, context.ego_yaw_rate,
    )  # fmt: skip
    return shift

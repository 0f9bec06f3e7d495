"""Host vehicle of a trace, and the frame of a virtual sensor on it, in the plane."""

from dataclasses import dataclass

import betterosi as osi
import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.plane_geometry import out_of_frame, turned

Box = tuple[float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Host:
    """Motion of the host vehicle."""

    id: int
    pose_world: Floats
    """(3,) x [m], y [m], yaw [rad] of its box centre."""
    velocity_world: Floats
    """(2,) [m/s]."""
    yaw_rate: float
    """[rad/s]."""
    rear_axle: tuple[float, float]
    """Origin of the vehicle frame, from the box centre [m]."""

    @classmethod
    def of(cls, truth: osi.GroundTruth) -> "Host | None":
        """Return the host vehicle of a message; None if it names none, or one that is not in it."""
        name = truth.host_vehicle_id
        moving = next((m for m in truth.moving_object if name is not None and m.id.value == name.value), None)
        if moving is None:
            return None
        base, attributes = moving.base, moving.vehicle_attributes
        axle = attributes.bbcenter_to_rear if attributes is not None else None
        return cls(
            id=name.value,
            pose_world=np.array([base.position.x, base.position.y, base.orientation.yaw]),
            velocity_world=np.array([base.velocity.x, base.velocity.y]) if base.velocity else np.zeros(2),
            yaw_rate=base.orientation_rate.yaw if base.orientation_rate else 0.0,
            rear_axle=(axle.x, axle.y) if axle is not None else (0.0, 0.0),
        )


@dataclass(frozen=True, slots=True)
class SensorFrame:
    """Pose of a virtual sensor in the ego frame, the box centre of the host."""

    pose_ego: Floats
    """(3,) x [m], y [m], yaw [rad]."""

    def place(self, box: Box) -> Box:
        """Return a box in the ego frame; unchanged, bit for bit, if the frames are the same."""
        if not self.pose_ego.any():
            return box
        x, y, heading = out_of_frame(np.array([box[:3]]), self.pose_ego)[0].tolist()
        return (x, y, heading, *box[3:])

    def turn(self, velocity: Floats) -> Floats:
        """Return a vector (2,) on the axes of the ego frame."""
        return turned(velocity, float(self.pose_ego[2]))


def sensor_frame(mounting: osi.MountingPosition | None, host: Host | None) -> SensorFrame:
    """Return the frame of a virtual sensor; its mounting position is relative to the rear axle of the host."""
    axle = np.array(host.rear_axle if host else (0.0, 0.0))
    at = mounting.position if mounting is not None else None
    yaw = mounting.orientation.yaw if mounting is not None and mounting.orientation is not None else 0.0
    offset = np.array([at.x, at.y]) if at is not None else np.zeros(2)
    return SensorFrame(np.array([*(axle + offset), yaw]))


def over_ground(velocity: Floats, position_ego: Floats, host: Host) -> Floats:
    """(2,) velocity over ground, on the axes of the ego frame, of an object that moves at `velocity` in that frame."""
    x, y = position_ego.tolist()
    swept = host.yaw_rate * np.array([-y, x])
    found: Floats = velocity + swept + turned(host.velocity_world, -float(host.pose_world[2]))
    return found

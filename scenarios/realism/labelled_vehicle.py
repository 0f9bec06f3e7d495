"""A vehicle in one frame: its points, its labelled box, and the LIDARs that hit it."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.plane_geometry import turned

GROWN_M = 0.15
"""[m] Margin around the labelled box: points this far outside belong to the vehicle."""
GROUND_M = 0.15
"""[m] Points below this height may be ground."""
ABOVE_M = 0.20
"""[m] Margin above the labelled box."""
POINTS_MIN = 10
"""Least number of points of a vehicle with statistics."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledVehicle:
    """Points of a vehicle in one frame, with its label."""

    data_set: int
    """Number of its data set."""
    actor_id: int
    """Id in that data set."""
    frame: int
    """Frame in that data set."""
    kind: str
    """Kind of vehicle."""
    points_ego: Floats
    """(N, 3) ego frame, z from the ground [m]."""
    line: Ints
    """(N,) scan line, unit and layer, of each point."""
    box: Floats
    """(5,) label: x, y [m] and yaw [rad] in the ego frame, length and width [m]."""
    lidars: Floats
    """(U, 2) positions of the LIDARs with points on the vehicle, ego frame [m]; the first has most of them."""

    @property
    def points_box(self) -> Floats:
        """(N, 2) points in the frame of the box, x forward from its centre [m]."""
        return turned(self.points_ego[:, :2] - self.box[:2], -self.box[2])

    @property
    def lidars_box(self) -> Floats:
        """(U, 2) LIDARs in the frame of the box [m]."""
        return turned(self.lidars - self.box[:2], -self.box[2])

    @property
    def range_m(self) -> float:
        """Horizontal distance from the first LIDAR to the box centre [m]."""
        return float(np.hypot(*self.lidars_box[0]))

    @property
    def aspect_deg(self) -> float:
        """Angle between the long axis and the line of sight [deg], from 0, end on, to 90, abreast."""
        forward, left = np.abs(self.lidars_box[0])
        return float(np.degrees(np.arctan2(left, forward)))

    @property
    def front_seen(self) -> bool:
        """True if the first LIDAR is ahead of the box centre."""
        return bool(self.lidars_box[0, 0] > 0.0)

    @property
    def seen_from_outside(self) -> bool:
        """True if a LIDAR is in front of the plane of a face."""
        return bool((np.abs(self.lidars_box) > 0.5 * self.box[3:]).any())


def in_box(points: Floats, box: Floats, height_m: float) -> Bools:
    """Mask the points of a vehicle: inside its box grown by 15 cm, clear of the ground and of objects above.

    Parameters
    ----------
    points
        (N, 3) in the frame of the box's x, y and yaw, z from the ground [m].
    box
        (5,) x, y [m], yaw [rad], length and width [m].
    height_m
        Height of the vehicle [m].
    """
    local = np.abs(turned(points[:, :2] - box[:2], -box[2]))
    inside = (local <= 0.5 * box[3:] + GROWN_M).all(axis=1)
    mask: Bools = inside & (points[:, 2] >= GROUND_M) & (points[:, 2] <= height_m + ABOVE_M)
    return mask

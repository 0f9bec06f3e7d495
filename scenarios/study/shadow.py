"""What has to stand on a line beside the ego, lest its LIDARs see what is behind."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from sensor_model.rig import Mount, Rig
from sim.world import Floats


def outline(pose: Floats, size_m: Sequence[float]) -> Floats:
    """Points (44, 2) along the four sides of a box (length, width, height) at a pose (3,), corners included [m]."""
    along = np.linspace(-0.5, 0.5, 11)
    edge = np.full_like(along, 0.5)
    sides = ((along, edge), (along, -edge), (edge, along), (-edge, along))
    points = np.concatenate([np.column_stack(side) for side in sides]) * size_m[:2]
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    turned: Floats = points @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]
    return turned


def shadow(rig: Rig, points_ego: Floats, line_y_m: float) -> tuple[float, float]:
    """From where to where the line y = `line_y_m`, left of the ego, lies between points (N, 2) behind it and a LIDAR.

    Only LIDARs that look in a point's direction count. The line is in the ego frame as well [m].
    """
    crossings = []
    for mount in rig.mounts:
        origin = np.array([mount.x_m + rig.rear_axle_x_m, mount.y_m])
        ray = points_ego - origin
        ray = ray[_looks_along(mount, ray)]
        crossings.append(origin[0] + ray[:, 0] * (line_y_m - origin[1]) / ray[:, 1])
    x_m = np.concatenate(crossings)
    return float(x_m.min()), float(x_m.max())


def _looks_along(mount: Mount, ray: Floats) -> npt.NDArray[np.bool_]:
    """Whether rays (N, 2) from a LIDAR lie in its field of view (N,)."""
    azimuth_deg = (np.degrees(np.arctan2(ray[:, 1], ray[:, 0])) - mount.yaw_deg + 180.0) % 360.0 - 180.0
    left_deg = max(fan.start_deg for fan in mount.model.fans)
    right_deg = min(fan.stop_deg for fan in mount.model.fans)
    inside: npt.NDArray[np.bool_] = (right_deg <= azimuth_deg) & (azimuth_deg <= left_deg)
    return inside

"""What has to stand on a line beside the ego, lest its LIDARs see what is behind."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.optimize import brentq

from scenarios.arrays import Bools, Floats
from sensor_model.rig.rig import Mount, Rig


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
    x_m = np.concatenate([at[0] + ray[:, 0] * (line_y_m - at[1]) / ray[:, 1] for at, ray in _rays(rig, points_ego)])
    return float(x_m.min()), float(x_m.max())


def cover(rig: Rig, points_ego: Floats, line_y_m: float, share: float) -> float:
    """To where on that line, from its rear end on, a screen has to reach to hide so much of the points' angle.

    The angle is the sum of those under which the LIDARS see the points: their beams are evenly spread.
    """
    spans = [(at, np.arctan2(ray[:, 1], ray[:, 0])) for at, ray in _rays(rig, points_ego) if len(ray)]
    whole = sum(float(np.ptp(bearing)) for _, bearing in spans)

    def seen(end_m: float) -> float:
        """Angle ahead of the screen's end."""
        ends = [(math.atan2(line_y_m - at[1], end_m - at[0]), bearing) for at, bearing in spans]
        return sum(float(np.clip(end, bearing.min(), bearing.max()) - bearing.min()) for end, bearing in ends)

    left_m, right_m = shadow(rig, points_ego, line_y_m)
    return float(brentq(lambda end_m: seen(end_m) - (1.0 - share) * whole, left_m - 0.1, right_m + 0.1))


def _rays(rig: Rig, points_ego: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Where each LIDAR is (2,), and the rays (N, 2) from it to those points that lie in its field of view."""
    for mount in rig.mounts:
        at = np.array([mount.x_m + rig.rear_axle_x_m, mount.y_m])
        yield at, (points_ego - at)[_looks_along(mount, points_ego - at)]


def _looks_along(mount: Mount, ray: Floats) -> Bools:
    """Whether rays (N, 2) from a LIDAR lie in its field of view (N,)."""
    azimuth_deg = (np.degrees(np.arctan2(ray[:, 1], ray[:, 0])) - mount.yaw_deg + 180.0) % 360.0 - 180.0
    left_deg = max(fan.start_deg for fan in mount.model.fans)
    right_deg = min(fan.stop_deg for fan in mount.model.fans)
    inside: Bools = (right_deg <= azimuth_deg) & (azimuth_deg <= left_deg)
    return inside

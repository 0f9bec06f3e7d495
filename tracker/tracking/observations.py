"""Boxes in the odometry frame, with noise floors."""

from dataclasses import dataclass

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.geometry import rotate
from luxloop.tracker.kernels import placed
from luxloop.tracker.records import Boxes
from luxloop.tracker.tracking.filters import FilterConfig


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """B boxes in the odometry frame; headings are modulo a quarter turn."""

    center: Floats
    """(B, 2) [m]."""
    heading: Floats
    """(B,)."""
    size: Floats
    """(B, 2) seen extent along and across heading [m]."""
    corner_sign: Ints
    """(B, 2) the nearest corner, signs in the box's frame."""
    covariance: Floats
    """(B, 3, 3) of corner x, corner y, heading."""
    cut: Bools
    """(B, 4) mask of truncated ends: front, left, rear and right with respect to the heading."""
    flat: Bools
    """(B,) mask of boxes that lack a side that a vehicle would show, or are a part of a larger object."""
    time_offset: Floats
    """(B,) time of the box minus time of the scan [s]."""
    sensor: Floats
    """(B, 2) mean position of the units that saw the box [m]."""

    def __len__(self) -> int:
        return len(self.heading)

    @property
    def untruncated(self) -> Bools:
        """(B, 2) mask of sides along and across the heading that are truncated at neither end."""
        return uncut(self.cut)

    @property
    def corner(self) -> Floats:
        """(B, 2) the nearest corner [m]."""
        return self.center + rotate(0.5 * self.corner_sign * self.size, self.heading)


def uncut(cut: Bools) -> Bools:
    """(..., 2) mask of sides along and across that are truncated, `cut` (..., 4), at neither end."""
    return np.asarray(~(cut[..., :2] | cut[..., 2:]))


def observe(boxes: Boxes, ego_pose_odom: Floats, config: FilterConfig) -> Observations:
    """Transform boxes from the ego frame to the odometry frame and add the noise floors to their covariance."""
    floors = config.position_std_floor_m**2, config.heading_std_floor_rad**2
    return Observations(
        center=placed(boxes.center_ego, ego_pose_odom),
        heading=boxes.heading + ego_pose_odom[2],
        size=boxes.size,
        corner_sign=boxes.corner_sign,
        covariance=turned_covariances(boxes.covariance, ego_pose_odom[2], floors),
        cut=np.concatenate([boxes.cut[:, :, 1], boxes.cut[:, :, 0]], axis=1),
        flat=boxes.flat,
        time_offset=boxes.time_offset,
        sensor=placed(boxes.viewpoint_ego, ego_pose_odom),
    )


@kernel()
def turned_covariances(covariance: Floats, yaw: float, floors: tuple[float, float]) -> Floats:
    """(B, 3, 3) covariances of x, y and heading, turned by a yaw angle, plus variances of position and heading."""
    x, y = elementary.cos(yaw), elementary.sin(yaw)
    turned = np.empty((len(covariance), 3, 3))
    for b in range(len(covariance)):
        xx, xy, yy = covariance[b, 0, 0], covariance[b, 0, 1], covariance[b, 1, 1]
        xh, yh = covariance[b, 0, 2], covariance[b, 1, 2]
        turned[b, 0, 0] = x * x * xx - 2.0 * x * y * xy + y * y * yy + floors[0]
        turned[b, 1, 1] = y * y * xx + 2.0 * x * y * xy + x * x * yy + floors[0]
        turned[b, 0, 1] = turned[b, 1, 0] = x * y * (xx - yy) + (x * x - y * y) * xy
        turned[b, 0, 2] = turned[b, 2, 0] = x * xh - y * yh
        turned[b, 1, 2] = turned[b, 2, 1] = y * xh + x * yh
        turned[b, 2, 2] = covariance[b, 2, 2] + floors[1]
    return turned

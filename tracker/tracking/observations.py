"""Boxes as the tracking half sees them: in the odometry frame, with the noise that the fit cannot know."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import rotate
from tracker.records import Boxes
from tracker.tracking.filters import FilterConfig


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """B boxes in the odometry frame; heading modulo a quarter turn."""

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
    """(B, 4) whether it may go on beyond its front, left, rear and right end, as its heading names them."""
    flat: Bools
    """(B,) whether it misses a side that a vehicle would show, or is but a part of something larger."""
    time_offset: Floats
    """(B,) when the box was there, after the scan's time [s]."""
    sensor: Floats
    """(2,) where the ego is [m]."""

    def __len__(self) -> int:
        return len(self.heading)

    @property
    def whole(self) -> Bools:
        """(B, 2) whether what is seen along and across the heading is cut off at neither end."""
        return uncut(self.cut)

    @property
    def corner(self) -> Floats:
        """(B, 2) the nearest corner [m]."""
        return self.center + rotate(0.5 * self.corner_sign * self.size, self.heading)


def uncut(cut: Bools) -> Bools:
    """(..., 2) whether a box is whole along and across: cut (..., 4) at neither its front nor rear, left nor right."""
    return np.asarray(~(cut[..., :2] | cut[..., 2:]))


def observe(boxes: Boxes, ego_pose_odom: Floats, config: FilterConfig) -> Observations:
    """Carry boxes from the ego frame into the odometry frame and add the noise floors to their covariance."""
    cos, sin = np.cos(ego_pose_odom[2]), np.sin(ego_pose_odom[2])
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    position_variance = config.position_std_floor_m**2
    floor = np.diag([position_variance, position_variance, config.heading_std_floor_rad**2])
    return Observations(
        center=boxes.center_ego @ turn[:2, :2].T + ego_pose_odom[:2],
        heading=boxes.heading + ego_pose_odom[2],
        size=boxes.size,
        corner_sign=boxes.corner_sign,
        covariance=turn @ boxes.covariance @ turn.T + floor,
        cut=np.concatenate([boxes.cut[:, :, 1], boxes.cut[:, :, 0]], axis=1),
        flat=boxes.flat,
        time_offset=boxes.time_offset,
        sensor=ego_pose_odom[:2],
    )

"""Perfect observations of known vehicles, as the detection stage would deliver them."""

import numpy as np

from luxloop.tracker.geometry import rotate
from luxloop.tracker.tracking.observations import Observations

CORNERS = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])


def corners(pose, size):
    """Return (4, 2) corners of a box in the order of CORNERS."""
    return np.asarray(pose[:2]) + rotate(0.5 * CORNERS * np.asarray(size), pose[2])


def observe_boxes(
    poses,
    sizes,
    ego=(0.0, 0.0),
    quarters=0,
    position_std_m=0.05,
    heading_std_rad=0.02,
    time_offset=0.0,
    cut=(False, False, False, False),
):
    """Return observations of boxes (x, y, yaw) with (length, width), headings rotated by `quarters` quarter turns.

    `cut` marks truncated ends of every box: front, left, rear and right with respect to the observed heading.
    """
    poses, sizes = np.atleast_2d(poses).astype(float), np.atleast_2d(sizes).astype(float)
    heading = poses[:, 2] + quarters * np.pi / 2
    size = sizes[:, ::-1] if quarters % 2 else sizes
    nearest = []
    for center, yaw, extent in zip(poses[:, :2], heading, size, strict=True):
        distance = np.linalg.norm(corners((*center, yaw), extent) - ego, axis=1)
        nearest.append(CORNERS[np.argmin(distance)])
    variance = np.diag([position_std_m**2, position_std_m**2, heading_std_rad**2])
    return Observations(
        center=poses[:, :2],
        heading=heading,
        size=size.copy(),
        corner_sign=np.array(nearest, dtype=np.int64),
        covariance=np.tile(variance, (len(poses), 1, 1)),
        flat=np.zeros(len(poses), dtype=np.bool_),
        time_offset=np.full(len(poses), time_offset),
        cut=np.tile(np.array(cut, dtype=bool), (len(poses), 1)),
        sensor=np.tile(np.asarray(ego, dtype=float), (len(poses), 1)),
    )

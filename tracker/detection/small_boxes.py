"""Small boxes: segments of the size of a person or a bicycle, also those below the size of a vehicle."""

import numpy as np

from tracker.arrays import Bools
from tracker.geometry import rotate
from tracker.records import Detection, SmallBoxes
from tracker.scan import Scan

MARGIN_M = 0.3
"""Extents of a segment exceed those of its object by range noise and by swinging legs [m]."""


def small_boxes(found: Detection, scan: Scan, longer_max_m: float, wider_max_m: float) -> SmallBoxes:
    """Return the best rectangles of the segments that may be a person or a bicycle, odometry frame.

    Parameters
    ----------
    found
        Results of detection.
    scan
        The scan they come from.
    longer_max_m, wider_max_m
        Maximum length and width of a small road user [m].
    """
    each = np.arange(found.segments.count)
    best = found.candidates.best
    center, heading, size = (
        field[each, best] for field in (found.candidates.center_ego, found.candidates.heading, found.candidates.size)
    )
    fits: Bools = (size.max(axis=1) <= longer_max_m + MARGIN_M) & (size.min(axis=1) <= wider_max_m + MARGIN_M)
    kept = np.flatnonzero(fits)
    yaw = float(scan.ego_pose_odom[2])
    used = found.segments.label >= 0
    label, count = found.segments.label[used], found.segments.count
    time = np.bincount(label, scan.time_offset[used], count) / np.maximum(np.bincount(label, minlength=count), 1)
    return SmallBoxes(
        segment=kept,
        center=rotate(center[kept], yaw) + scan.ego_pose_odom[:2],
        heading=heading[kept] + yaw,
        size=size[kept],
        time_offset=time[kept],
    )

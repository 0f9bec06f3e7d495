"""Small boxes: segments of the size of a person or a bicycle, also those below the size of a vehicle."""

import numpy as np

from luxloop.tracker.arrays import Floats, Floats32
from luxloop.tracker.kernels.odometry import placed
from luxloop.tracker.records import Detection, Segments, SmallBoxes
from luxloop.tracker.scan import Scan

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
    candidates, segments = found.candidates, found.segments
    length, width = candidates.size[np.arange(segments.count), candidates.best].T
    longer, shorter = np.maximum(length, width), np.minimum(length, width)
    kept = np.flatnonzero((longer <= longer_max_m + MARGIN_M) & (shorter <= wider_max_m + MARGIN_M))
    best = kept, candidates.best[kept]
    return SmallBoxes(
        segment=kept,
        center=placed(candidates.center_ego[best], scan.ego_pose_odom),
        heading=candidates.heading[best] + scan.ego_pose_odom[2],
        size=candidates.size[best],
        time_offset=mean_times(segments, scan.time_offset)[kept] if len(kept) else np.zeros(0),
    )


def mean_times(segments: Segments, time_offset: Floats32) -> Floats:
    """(S,) mean time of the points of each segment, relative to that of the scan [s]; 0 for an empty one."""
    bins = segments.label + 1  # the first one is that of points in no segment
    total, points = np.bincount(bins, time_offset, segments.count + 1), np.bincount(bins, None, segments.count + 1)
    return np.asarray(total[1:] / np.maximum(points[1:], 1))

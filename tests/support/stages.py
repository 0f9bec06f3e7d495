"""The stages of detection on arrays of points."""

from typing import NamedTuple

import numpy as np

from luxloop.tracker.detection import boxes, rectangles, segmentation, selection, tlinkage
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.records import Boxes, Candidates, Linkage, SegmentedPoints, Segments

LIDAR = LidarConfig()


class Fitted(NamedTuple):
    points: SegmentedPoints
    linkage: Linkage
    candidates: Candidates
    boxes: Boxes


def one_segment(count):
    """All points are one segment."""
    return Segments(label=np.zeros(count, dtype=np.int64), count=1)


def as_one_segment(points):
    """Points (N, 2 or 3) as one segment, sorted."""
    return segmentation.sort_by_segment(points, one_segment(len(points)))


def fit_points(
    points, segments=None, linkage=None, rectangle=None, choice=None, box=None, cut_off=None, viewpoints=None
):
    """Fit points (N, 2), all kept, with the given or default configs; `cut_off` (N,) marks truncated points.

    `viewpoints` (N, 2) are the positions of their units.
    """
    if segments is None:
        segments = segmentation.segment(points, np.ones(len(points), bool), segmentation.SegmentationConfig())
    sorted_points = segmentation.sort_by_segment(points, segments, truncated=cut_off, viewpoints=viewpoints)
    linked = tlinkage.link(sorted_points, linkage or tlinkage.LinkageConfig(), LIDAR)
    headings = rectangles.headings(sorted_points, linked, rectangle or rectangles.RectangleConfig())
    candidates = selection.select(
        sorted_points, linked, headings, choice or selection.SelectionConfig(), LIDAR.range_std_m
    )
    built = boxes.build(sorted_points, linked, candidates, box or boxes.BoxConfig())
    return Fitted(sorted_points, linked, candidates, built)


def off_quarter(heading, truth):
    """Difference of headings modulo a quarter turn, signed [deg]."""
    return np.rad2deg((heading - truth + np.pi / 4) % (np.pi / 2) - np.pi / 4)

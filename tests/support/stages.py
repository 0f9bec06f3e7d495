"""The stages of detection on arrays of points."""

from typing import NamedTuple

import numpy as np

from luxloop.tracker.detection import boxes, rectangles, segmentation, selection, tlinkage
from luxloop.tracker.records import Boxes, Candidates, Linkage, Segments


class Fitted(NamedTuple):
    segments: Segments
    linkage: Linkage
    candidates: Candidates
    boxes: Boxes


def one_segment(count):
    """All points are one segment."""
    return Segments(label=np.zeros(count, dtype=np.int64), count=1)


def fit_points(
    points, segments=None, linkage=None, rectangle=None, choice=None, box=None, cut_off=None, viewpoints=None
):
    """Fit points (N, 2), all kept, with the given or default configs; `cut_off` (N,) marks truncated points.

    `viewpoints` (N, 2) are the positions of their units.
    """
    if segments is None:
        segments = segmentation.segment(points, np.ones(len(points), bool), segmentation.SegmentationConfig())
    linked = tlinkage.link(points, segments, linkage or tlinkage.LinkageConfig())
    found = rectangles.fit(points, segments, linked, rectangle or rectangles.RectangleConfig())
    candidates = selection.select(points, segments, linked, found, choice or selection.SelectionConfig())
    cut_off = np.zeros(len(points), dtype=bool) if cut_off is None else cut_off
    config = box or boxes.BoxConfig()
    built = boxes.build(points, np.zeros(len(points)), segments, linked, candidates, cut_off, config, viewpoints)
    return Fitted(segments, linked, candidates, built)


def off_quarter(heading, truth):
    """Difference of headings modulo a quarter turn, signed [deg]."""
    return np.rad2deg((heading - truth + np.pi / 4) % (np.pi / 2) - np.pi / 4)

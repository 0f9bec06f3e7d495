"""Boxes of whole cars as the input of trackers that take a detector."""

import numpy as np

from luxloop.tracker.records import Boxes, Candidates, Detection, Linkage, Segments
from luxloop.tracker.scan import Scan

CAR_M = np.array([4.5, 1.8])
DT_S = 0.08


class ScriptedDetector:
    """Detector that returns given boxes by the index of the scan, without its points."""

    def __init__(self, drive):
        self._drive, self._frame = drive, -1

    def step(self, _scan, _movers=None, _long=None):
        """Return the boxes of the next scan."""
        self._frame += 1
        return detection(*self._drive[self._frame])


def detection(centers, headings):
    """Return whole cars at `centers` (B, 2) with `headings` (B,), ego frame."""
    centers, headings = np.reshape(centers, (-1, 2)).astype(float), np.reshape(headings, -1).astype(float)
    count = len(centers)
    cos, sin = np.cos(headings), np.sin(headings)
    along = cos * centers[:, 0] + sin * centers[:, 1]
    left = cos * centers[:, 1] - sin * centers[:, 0]
    sign = np.where(np.column_stack([along, left]) > 0.0, -1, 1)
    half = 0.5 * sign * CAR_M
    corner = centers + np.column_stack([cos * half[:, 0] - sin * half[:, 1], sin * half[:, 0] + cos * half[:, 1]])
    boxes = Boxes(
        segment=np.arange(count),
        center_ego=centers,
        heading=headings,
        size=np.tile(CAR_M, (count, 1)),
        corner_ego=corner,
        corner_sign=sign,
        covariance=np.tile(0.01 * np.eye(3), (count, 1, 1)),
        support=np.full(count, 40),
        time_offset=np.zeros(count),
        cut=np.zeros((count, 2, 2), bool),
        flat=np.zeros(count, bool),
        viewpoint_ego=np.zeros((count, 2)),
    )
    nothing = np.empty((0, 1))
    candidates = Candidates(nothing, np.empty((0, 1, 2)), np.empty((0, 1, 2)), nothing, np.empty(0, int))
    return Detection(Segments(np.empty(0, int), 0), Linkage(np.empty(0, int), np.empty(0)), candidates, boxes)


def scans(count, pose=(0.0, 0.0, 0.0)):
    """Return scans without points, `DT_S` apart."""
    return [Scan.from_points(DT_S * k, np.empty((0, 3)), pose) for k in range(count)]

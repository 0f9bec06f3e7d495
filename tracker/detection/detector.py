"""Detection: from one scan to the boxes of the vehicles in it."""

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from luxloop.arrays import Bools, Floats
from luxloop.tracker import merging
from luxloop.tracker.detection import (
    baselines,
    boxes,
    preprocess,
    rectangles,
    segmentation,
    selection,
    tlinkage,
    truncation,
)
from luxloop.tracker.detection.background import Background, BackgroundConfig
from luxloop.tracker.detection.baselines import BaselineConfig
from luxloop.tracker.detection.boxes import BoxConfig
from luxloop.tracker.detection.deskew import DeskewConfig, EgoMotion, undo_targets
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.preprocess import PreprocessConfig
from luxloop.tracker.detection.rectangles import RectangleConfig
from luxloop.tracker.detection.segmentation import SegmentationConfig
from luxloop.tracker.detection.selection import SelectionConfig
from luxloop.tracker.detection.tlinkage import LinkageConfig
from luxloop.tracker.detection.truncation import TruncationConfig
from luxloop.tracker.kernels import placed
from luxloop.tracker.records import Boxes, Candidates, Detection, Linkage, OrientedBoxes, SegmentedPoints, Segments
from luxloop.tracker.scan import Scan

CLOCK_DIGITS = 9
"""Decimal digits of times [s]: differences below a nanosecond are rounding errors."""


@dataclass(frozen=True, slots=True)
class DetectorConfig:
    """Settings of detection, one section per stage."""

    lidar: LidarConfig = field(default_factory=LidarConfig)
    preprocess: PreprocessConfig = field(default_factory=PreprocessConfig)
    deskew: DeskewConfig = field(default_factory=DeskewConfig)
    segmentation: SegmentationConfig = field(default_factory=SegmentationConfig)
    background: BackgroundConfig = field(default_factory=BackgroundConfig)
    truncation: TruncationConfig = field(default_factory=TruncationConfig)
    linkage: LinkageConfig = field(default_factory=LinkageConfig)
    rectangles: RectangleConfig = field(default_factory=RectangleConfig)
    selection: SelectionConfig = field(default_factory=SelectionConfig)
    baselines: BaselineConfig = field(default_factory=BaselineConfig)
    boxes: BoxConfig = field(default_factory=BoxConfig)


class BoxDetector(Protocol):
    """Detection stage of a tracker: scans in, boxes out."""

    def check(self, scan: Scan) -> None:
        """Raise ValueError for a scan that `step` does not accept. The detector stays unchanged."""

    def step(self, scan: Scan, movers: OrientedBoxes | None = None, long: OrientedBoxes | None = None) -> Detection:
        """Detect the vehicles in a scan.

        Parameters
        ----------
        scan
            Later than all scans before.
        movers
            Known vehicles at the scan's time, to compensate for their motion during the sweep.
        long
            Known vehicles that are longer than a car, whose pieces form one segment.
        """


class Detector:
    """Vehicle detection in a sequence of scans. Its memory is the motion of the ego and the position of walls.

    Other trackers use it by calling `step`, and process its boxes themselves. Subclasses may replace each of the stages
    `segment`, `link`, `fit` and `box`.
    """

    def __init__(self, config: DetectorConfig | None = None) -> None:
        self.config = config or DetectorConfig()
        self._ego_motion = EgoMotion(self.config.deskew)
        self._background = Background(self.config.background, self.config.segmentation, self.config.lidar)
        self._time = -math.inf

    def check(self, scan: Scan) -> None:
        """Raise ValueError for a scan that `step` does not accept: malformed, or not later than the one before."""
        scan.check()
        if round(scan.time - self._time, CLOCK_DIGITS) <= 0.0:
            raise ValueError(
                f"the scan of {scan.time} s is not later than the one before, of {self._time} s; "
                "drop it, or use a new tracker for another recording"
            )

    def step(self, scan: Scan, movers: OrientedBoxes | None = None, long: OrientedBoxes | None = None) -> Detection:
        """Detect the vehicles in a scan.

        Parameters
        ----------
        scan
            Later than all scans before; see `tracker.tracker.Tracker.step` for scans with few or invalid points.
        movers
            Known vehicles, predicted to the scan's time, to compensate for their motion during the sweep. Without them
            only ego motion is compensated.
        long
            Known vehicles that are longer than a car, odometry frame; all points inside one of them form one segment.

        Raises
        ------
        ValueError
            As `check`.
        """
        self.check(scan)
        self._time = scan.time
        config = self.config
        keep = preprocess.keep(scan, config.preprocess)
        swept = preprocess.masked(scan)
        scan = self._ego_motion.undo(swept)
        segments = self.segment(scan, keep, long)
        truncated = truncation.cut_off(swept, keep, segments, config.preprocess.range_max_m, config.truncation)
        points = sorted_points(scan, segments, truncated)
        if movers is not None:
            points = undo_targets(points, scan.ego_pose_odom, movers)
        linkage = self.link(points)
        candidates = self.fit(points, linkage)
        return Detection(segments, linkage, candidates, self.box(points, linkage, candidates))

    def segment(self, scan: Scan, keep: Bools, long: OrientedBoxes | None) -> Segments:
        """Group the points to `keep` (N,) into segments; remove walls and merge the pieces of long vehicles."""
        segments = segmentation.segment(scan.points_ego, keep, self.config.segmentation)
        points_odom = into_odom(scan)
        ego_odom = scan.ego_pose_odom[:2]
        self._background.forget(scan.time, points_odom, ego_odom)
        segments = self._background.remove(points_odom, segments, ego_odom)
        return segments if long is None else merging.merge_segments(points_odom, segments, long)

    def link(self, points: SegmentedPoints) -> Linkage:
        """Separate lines from outliers in every segment."""
        return tlinkage.link(points, self.config.linkage, self.config.lidar)

    def fit(self, points: SegmentedPoints, linkage: Linkage) -> Candidates:
        """Fit a rectangle per method to every segment, and select the best."""
        config = self.config
        headings = rectangles.headings(points, linkage, config.rectangles)
        range_std_m = config.lidar.range_std_m
        candidates = selection.select(points, linkage, headings, config.selection, range_std_m)
        return baselines.append(points, linkage, candidates, config.baselines, range_std_m)

    def box(self, points: SegmentedPoints, linkage: Linkage, candidates: Candidates) -> Boxes:
        """Make boxes of the best rectangles of vehicle size."""
        fitted = boxes.build(points, linkage, candidates, self.config.boxes)
        return fitted.subset(~boxes.in_shadow(fitted))


def sorted_points(scan: Scan, segments: Segments, truncated: Bools) -> SegmentedPoints:
    """Return the points of a scan in segments; `truncated` (N,) is the mask of those at truncated ends."""
    units, layers = scan.unit_positions_ego, int(scan.layer.max(initial=0)) + 1
    return segmentation.sort_by_segment(
        scan.points_ego,
        segments,
        scan_line=scan.unit.astype(np.int64) * layers + scan.layer,
        time_offset=scan.time_offset,
        viewpoints=None if units is None else units.take(scan.unit, axis=0),
        truncated=truncated,
    )


def into_odom(scan: Scan) -> Floats:
    """(N, 2) points of the scan in the odometry frame [m]."""
    points = np.asarray(scan.points_ego, dtype=np.float64, order="C")
    return np.asarray(placed(points, np.asarray(scan.ego_pose_odom, dtype=np.float64)))

"""Boxes of the shipped detector, completed to whole vehicles: the measurements of the league's peers."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from luxloop.arrays import Floats
from luxloop.tracker.detection.detector import BoxDetector, Detector, DetectorConfig
from luxloop.tracker.geometry import rotate
from luxloop.tracker.scan import Scan

CAR_M = np.array([4.5, 1.8])
"""Length and width of a car [m]; hidden ends of a box are put there."""
WIDEST_M = 2.6
"""A box whose longer side is shorter shows the end of a vehicle [m]: trucks are 2.55 wide."""

MakeDetector = Callable[[DetectorConfig], BoxDetector]
"""Makes the detector; tests take one that returns given boxes."""


class Readings(NamedTuple):
    """B whole vehicles in the odometry frame."""

    center: Floats
    """(B, 2) [m]."""
    heading: Floats
    """(B,) along the length, modulo half a turn [rad]."""
    size: Floats
    """(B, 2) length, width [m]."""


class VehicleBoxes:
    """Detector with whole vehicles as output.

    The detector compensates for the motion of the ego; it gets no vehicles back from the peers, so that all of them
    have the same readings.
    """

    def __init__(self, config: DetectorConfig, make_detector: MakeDetector = Detector) -> None:
        self._detector = make_detector(config)

    def step(self, scan: Scan) -> Readings:
        """Return the vehicles of a scan, without boxes that are a part of a larger object (`Boxes.flat`)."""
        boxes = self._detector.step(scan).boxes
        boxes = boxes.subset(~boxes.flat)
        side = np.argmax(boxes.size, axis=1) == 0
        lengthwise = np.where(boxes.size.max(axis=1, initial=0.0) >= WIDEST_M, side, ~side)
        typical = np.where(lengthwise[:, None], CAR_M, CAR_M[::-1])
        whole = np.maximum(boxes.size, typical)
        center = boxes.corner_ego - rotate(0.5 * boxes.corner_sign * whole, boxes.heading)
        heading = boxes.heading + np.where(lengthwise, 0.0, 0.5 * np.pi)
        pose = scan.ego_pose_odom
        size = np.where(lengthwise[:, None], whole, whole[:, ::-1])
        return Readings(rotate(center, pose[2]) + pose[:2], heading + pose[2], size)

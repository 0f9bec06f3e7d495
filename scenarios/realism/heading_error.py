"""Heading errors of the tracker's rectangles, fitted to the points of labelled vehicles."""

from collections.abc import Sequence

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.plane_geometry import QUARTER, wrap
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.tracker.detection import rectangles, segmentation, selection, tlinkage
from luxloop.tracker.detection.detector import DetectorConfig
from luxloop.tracker.records import METHODS, Segments

REPORTED = ("area", "closeness", "variance", "tlinkage", "best")
"""Methods with a figure; `best` is the selected rectangle."""


def measure(vehicles: Sequence[LabelledVehicle]) -> tuple[Floats, Floats]:
    """Fit rectangles to each vehicle's points as one segment, with the tracker's default settings.

    Returns
    -------
    error_deg
        (V, len(REPORTED)) absolute heading errors modulo 90 degrees, at most 45.
    on_lines
        (V,) share of the points that T-linkage leaves on lines.
    """
    config = DetectorConfig()
    points, segments = _as_segments(vehicles)
    lines = np.concatenate([vehicle.line for vehicle in vehicles])
    sorted_points = segmentation.sort_by_segment(points, segments, scan_line=lines)
    linkage = tlinkage.link(sorted_points, config.linkage, config.lidar)
    headings = rectangles.headings(sorted_points, linkage, config.rectangles)
    candidates = selection.select(sorted_points, linkage, headings, config.selection, config.lidar.range_std_m)
    yaw = np.array([vehicle.box[2] for vehicle in vehicles])
    heading = np.column_stack(
        [candidates.heading[:, : len(METHODS) - 1], candidates.heading[np.arange(len(yaw)), candidates.best]]
    )
    error = np.degrees(np.abs(wrap(heading - yaw[:, None], QUARTER)))
    on_lines = np.bincount(segments.label, linkage.line >= 0, segments.count) / np.bincount(segments.label)
    return error, on_lines


def _as_segments(vehicles: Sequence[LabelledVehicle]) -> tuple[Floats, Segments]:
    """Return the points of all vehicles, a segment each."""
    sizes = [len(vehicle.points_ego) for vehicle in vehicles]
    label: Ints = np.repeat(np.arange(len(sizes)), sizes)
    return np.concatenate([vehicle.points_ego for vehicle in vehicles]), Segments(label, len(sizes))

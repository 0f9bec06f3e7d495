"""The detector without the tracker, as other trackers use it."""

import numpy as np
import pytest
from support import short_run
from support.shapes import l_shape
from support.stages import one_segment

from luxloop.tracker.detection.detector import Detector, DetectorConfig, sorted_points
from luxloop.tracker.detection.preprocess import PreprocessConfig
from luxloop.tracker.records import MODELS, OrientedBoxes, Segments, Status, StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig
from luxloop.tracker.tracking.filters import FilterConfig
from luxloop.tracker.tracking.observations import observe


def scans(frames):
    """A car passes a stationary ego from 9 m ahead at 5 m/s; the rear half of the sweep is 20 ms late."""
    for k in range(frames):
        points = np.column_stack([l_shape(0.0, length=4.5, width=1.8, step=0.1), np.full(64, 0.6)])
        late = np.where(points[:, 0] < 12.0, 0.02, 0.0)
        points[:, 0] += 5.0 * (0.08 * k + late)
        yield Scan.from_points(0.08 * k, points, time_offset=late)


def test_the_trace_of_the_tracker_contains_the_detection():
    """Without movers the points keep their measured positions."""
    detector, tracker = Detector(), Tracker()
    for k, scan in enumerate(scans(6)):
        detection, (_, trace) = detector.step(scan), tracker.step(scan)
        np.testing.assert_array_equal(detection.segments.label, trace.segments.label)
        assert len(detection.boxes) == len(trace.boxes) == 1
        if k == 0:
            np.testing.assert_array_equal(detection.boxes.corner_ego, trace.boxes.corner_ego)
    late = detection.boxes.corner_ego[0, 0] - trace.boxes.corner_ego[0, 0]
    assert late == pytest.approx(5.0 * 0.02, abs=0.03)


def test_target_motion_is_compensated_for_movers():
    (scan,) = scans(1)
    size, velocity = np.array([[4.5, 1.8]]), np.array([[5.0, 0.0]])
    car = OrientedBoxes(np.array([[12.25, 5.9]]), np.zeros(1), size, velocity, np.array([9]))
    found = Detector().step(scan, car)
    np.testing.assert_allclose(found.boxes.corner_ego, [[10.0, 5.0]], atol=0.01)
    np.testing.assert_allclose(np.sort(found.boxes.size), [[1.8, 4.5]], atol=0.02)  # headings are modulo a quarter turn


def test_a_detector_accepts_the_settings_of_the_tracker():
    near = PreprocessConfig(range_max_m=5.0)
    for config in (DetectorConfig(preprocess=near), TrackerConfig(preprocess=near)):
        assert len(Detector(config).step(next(scans(1))).boxes) == 0


class NearestBox:
    """Minimal tracker with the detector: each box is the vehicle that was nearest in the last scan."""

    def __init__(self, config):
        self.detector, self.center, self.id, self.born = Detector(config), np.empty((0, 2)), np.empty(0, int), 0

    def step(self, scan):
        found = self.detector.step(scan)
        seen = observe(found.boxes, scan.ego_pose_odom, FilterConfig())
        self.id = np.array([self.name(center) for center in seen.center], dtype=int)
        self.center = seen.center
        trace = StepTrace(found.segments, found.linkage, found.candidates, found.boxes, self.id)
        return as_tracks(seen, self.id), trace

    def name(self, center):
        distance = np.linalg.norm(self.center - center, axis=1)
        if len(distance) and distance.min() < 2.0:
            return self.id[distance.argmin()]
        self.born += 1
        return self.born


def as_tracks(seen, ids):
    count = len(seen)
    mean = np.column_stack([seen.corner, np.zeros((count, 4)), seen.heading, np.zeros(count)])
    return Tracks(
        id=ids,
        status=np.full(count, Status.CONFIRMED, np.uint8),
        mean=mean,
        covariance=np.tile(np.eye(8), (count, 1, 1)),
        model_probability=np.tile(np.eye(len(MODELS))[0], (count, 1)),
        model=np.zeros(count, int),
        model_position_odom=np.repeat(mean[:, None, :2], len(MODELS), axis=1),
        corner_sign=seen.corner_sign,
        size=seen.size,
    )


def test_a_plug_in_with_the_detector_is_graded_by_its_fits_and_its_tracks():
    own, shipped = short_run.run(factory=NearestBox).metrics, short_run.result().metrics
    fits = "fit.heading_abs_mean_deg"
    assert own[fits].n == shipped[fits].n > 10
    assert own[fits].value == pytest.approx(shipped[fits].value, abs=1.0)
    assert own["track.hota"].value > 0.3


def test_scan_lines_are_units_times_layers():
    """Units 0 and 2 with layers 0 to 3: equal numbers for points of the same unit and layer only."""
    unit, layer = np.array([0, 0, 2, 2, 2, 0]), np.array([0, 3, 0, 3, 3, 3])
    scan = Scan.from_points(0.0, np.ones((6, 3)), unit=unit, layer=layer)
    points = sorted_points(scan, one_segment(6), np.zeros(6, bool))
    assert points.scan_line.tolist() == [0, 3, 8, 11, 11, 3]
    nothing = sorted_points(Scan.from_points(0.0, np.empty((0, 3))), Segments(np.empty(0, int), 0), np.zeros(0, bool))
    assert nothing.scan_line.shape == nothing.source.shape == (0,)
    assert nothing.offset.tolist() == [0]

"""Deskew: compensation of ego and target motion during the sweep of a scan."""

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st
from support.few import few
from support.shapes import Car, scan_car

from luxloop.sim.scripted.motions import Arc, Straight, state_at
from luxloop.tracker.detection.boxes import BoxConfig, build
from luxloop.tracker.detection.deskew import DeskewConfig, EgoMotion, twist, undo_targets
from luxloop.tracker.detection.detector import Detector
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.geometry import rotate
from luxloop.tracker.records import NOT_USED, Candidates, Linkage, OrientedBoxes, Segments, Status
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig

DT = 0.08
SWEEP_DEG_PER_S = 4500.0  # 12.5 turns a second


def scan_at(time, pose, points, time_offset):
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    count = len(points)
    return Scan(
        time=time,
        ego_pose_odom=np.asarray(pose, dtype=float),
        points_ego=np.column_stack([points, np.full(count, 0.6)]).astype(np.float32),
        time_offset=np.broadcast_to(np.asarray(time_offset, np.float32), count).copy(),
        unit=np.zeros(count, np.uint8),
        layer=np.zeros(count, np.uint8),
        echo=np.zeros(count, np.uint8),
        echo_pulse_width=np.ones(count, np.float32),
        flags=np.zeros(count, np.uint16),
    )


def seen_from(pose, points):
    """Transform points (N, 2) of the odometry frame into the frame of one pose, or of one pose per point."""
    pose = np.broadcast_to(pose, (len(points), 3))
    return rotate(points - pose[:, :2], -pose[:, 2])


# ---- ego motion


@given(
    velocity=st.tuples(st.floats(-40, 40), st.floats(-5, 5)),
    yaw_rate=st.floats(-2, 2),
    start=st.tuples(st.floats(-100, 100), st.floats(-100, 100), st.floats(-4, 4)),
    dt=st.floats(0.01, 0.5),
)
def test_twist_is_the_logarithm_of_the_relative_pose(velocity, yaw_rate, start, dt):
    """The oracle is the matrix exponential in SE(2)."""
    rate = np.array([[0.0, -yaw_rate, velocity[0]], [yaw_rate, 0.0, velocity[1]], [0.0, 0.0, 0.0]])
    cos, sin = np.cos(start[2]), np.sin(start[2])
    end = np.array([[cos, -sin, start[0]], [sin, cos, start[1]], [0.0, 0.0, 1.0]]) @ scipy.linalg.expm(rate * dt)
    heading = np.arctan2(end[1, 0], end[0, 0])  # wrapped, like the heading of the odometry
    found, turning = twist(np.array(start), np.array([end[0, 2], end[1, 2], heading]), dt)
    assert found == pytest.approx(np.array(velocity), abs=1e-8)
    assert turning == pytest.approx(yaw_rate, abs=1e-8)


@pytest.mark.parametrize(
    "motion", [Arc("arc", 15.0, 12.0), Arc("arc", 15.0, -12.0), Straight("straight", 30.0)], ids=["left", "right", "on"]
)
def test_landmarks_are_stationary_during_a_turn(motion):
    """Landmarks are measured from the ego pose at the time of the point, and moved to the time of the scan."""
    rng = np.random.default_rng(2)
    landmarks, tau = rng.uniform(-50, 50, (200, 2)), rng.uniform(-0.0134, 0.0134, 200).astype(np.float32)
    start, time = np.array([3.0, -2.0, 3.0]), 1.0  # close to the wrap of the heading

    def pose(t):
        return state_at([motion], start, t).pose

    def wrapped(t):
        x, y, yaw = pose(t)
        return np.array([x, y, np.arctan2(np.sin(yaw), np.cos(yaw))])

    raw = seen_from(np.array([pose(time + t) for t in tau.astype(float)]), landmarks)
    true = seen_from(pose(time), landmarks)
    ego = EgoMotion(DeskewConfig())
    first = scan_at(time - DT, wrapped(time - DT), raw, tau)
    assert np.array_equal(ego.undo(first).points_ego, first.points_ego), "the motion is unknown after one pose"
    second = ego.undo(scan_at(time, wrapped(time), raw, tau))
    assert np.abs(second.points_ego[:, :2] - true).max() < 2e-5  # float32 at 80 m
    assert (second.points_ego[:, 2] == np.float32(0.6)).all()
    assert np.abs(raw - true).max() > 0.15
    assert np.array_equal(second.time_offset, tau), "time offsets are kept for the target motion"


def test_deskew_can_be_disabled():
    ego = EgoMotion(DeskewConfig(motion="none"))
    for k in range(2):
        scan = scan_at(DT * k, (2.0 * k, 0.0, 0.0), [(10.0, 0.0)], 0.01)
        plain = ego.undo(scan)
        assert np.array_equal(plain.points_ego, scan.points_ego)
        assert not plain.time_offset.any()


def test_scans_of_the_same_time_are_not_deskewed():
    ego = EgoMotion(DeskewConfig())
    for x in (0.0, 1.0):
        scan = scan_at(5.0, (x, 0.0, 0.0), [(10.0, 0.0)], 0.01)
        assert np.array_equal(ego.undo(scan).points_ego, scan.points_ego)


# ---- target motion


def movers(*boxes):
    """Return tracks (x, y, heading, vx, vy) of cars."""
    table = np.array(boxes, dtype=float).reshape(-1, 5)
    count = len(table)
    sizes, hits = np.tile([4.6, 1.8], (count, 1)), np.full(count, 9)
    return OrientedBoxes(table[:, :2], table[:, 2], sizes, table[:, 3:], hits)


def test_points_of_a_track_are_moved_to_the_time_of_the_scan():
    """A rear seen by two units 13 ms apart is one line; points outside all tracks keep their position and time."""
    pose = np.array([5.0, 7.0, 0.5])
    tau = np.repeat([-0.0067, 0.0067, 0.0067], 10)
    velocity = rotate(np.array([25.0, 1.0]), 0.5)
    rear = np.column_stack([np.full(20, 17.7), np.tile(np.linspace(-0.9, 0.9, 10), 2)])
    wall = np.column_stack([np.linspace(0, 9, 10), np.full(10, 6.0)])
    when_seen = np.vstack([rear, wall])
    when_seen[:20] += np.outer(tau[:20], (25.0, 1.0))
    segments = Segments(np.repeat([0, 0, 1], 10), 2)
    center = rotate(np.array([20.0, 0.0]), 0.5) + pose[:2]
    points = sort_by_segment(when_seen, segments, time_offset=tau)
    still = undo_targets(points, pose, movers((*center, 0.5, *velocity)))
    assert still.xy == pytest.approx(np.vstack([rear, wall]), abs=1e-5)
    assert not still.time_offset[:20].any()
    assert still.time_offset[20:] == pytest.approx(tau[20:])


def test_a_segment_moves_with_the_nearest_track_and_other_points_stay():
    points = np.array([[10.0, 0.0], [10.2, 0.0], [10.1, 0.0], [30.0, 0.0]])
    segments = Segments(np.array([0, 0, NOT_USED, 1]), 2)
    near_and_far = movers((11.5, 0.0, 0.0, 5.0, 0.0), (10.5, 0.0, 0.0, 10.0, 0.0))
    swept = sort_by_segment(points, segments, time_offset=np.full(4, 0.01))
    still = undo_targets(swept, np.zeros(3), near_and_far)
    assert still.xy[:, 0] == pytest.approx([9.9, 10.1, 30.0])
    assert still.time_offset == pytest.approx([0.0, 0.0, 0.01])
    for far_away in (movers(), movers((50.0, 0.0, 0.0, 5.0, 0.0))):
        same = undo_targets(swept, np.zeros(3), far_away)
        assert same.xy == pytest.approx(points[[0, 1, 3]])


def test_the_time_of_a_box_is_the_mean_time_of_the_points_on_its_lines():
    points = np.array([[10.0, 0.0], [10.0, 1.0], [11.0, 1.0], [40.0, 5.0]])
    segments, line = Segments(np.array([0, 0, 0, 0]), 1), np.array([0, 0, 1, -1])
    one = np.zeros((1, 4))
    candidates = Candidates(one, np.full((1, 4, 2), 10.5), np.ones((1, 4, 2)), one, np.zeros(1, np.int64))
    tau = np.array([0.001, 0.003, 0.005, 0.5])
    swept = sort_by_segment(points, segments, time_offset=tau)
    built = build(swept, Linkage(line, np.zeros(1)), candidates, BoxConfig())
    assert built.time_offset == pytest.approx([0.003])


# ---- complete tracker


def oncoming(unit_yaw_deg, ego_mps, speed_mps=30.0, frames=21):
    """Yield (true centre, scan) of an oncoming car that ends 12 m in front of the ego, with a time per point.

    The unit measures its azimuth 0 at the time of the scan; None measures all azimuths at the same time.
    """
    rng = np.random.default_rng(7)
    for k in range(frames):
        ego_x = ego_mps * DT * k
        center = np.array([ego_x + 12.0 + (speed_mps + ego_mps) * DT * (frames - 1 - k), 3.5])
        points, _ = scan_car(Car((center[0] - ego_x, 3.5), np.pi), rng)
        azimuth = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
        tau = np.zeros(len(points)) if unit_yaw_deg is None else (unit_yaw_deg - azimuth) / SWEEP_DEG_PER_S
        points[:, 0] -= (speed_mps + ego_mps) * tau
        yield center, scan_at(DT * k, (ego_x, 0.0, 0.0), points, tau)


def lead(unit_yaw_deg, ego_mps=0.0, deskew=None, detector=None):
    """Return the longitudinal error of the track's front over the last frames [m], positive forward."""
    tracker, leads = Tracker(TrackerConfig(deskew=deskew or DeskewConfig()), detector), []
    for k, (center, scan) in enumerate(oncoming(unit_yaw_deg, ego_mps)):
        tracks, _ = tracker.step(scan)
        if k >= 17:
            (confirmed,) = np.flatnonzero(tracks.status == Status.CONFIRMED)
            front = tracks.center_odom[confirmed, 0] - 0.5 * tracks.size[confirmed, 0]
            leads.append(center[0] - 0.5 * Car().size[0] - front)
    return np.array(leads)


@pytest.mark.parametrize("ego_mps", few([0.0, 15.0], 15.0))
@pytest.mark.parametrize("unit_yaw_deg", [30.0, -30.0])
def test_an_oncoming_car_is_tracked_at_the_time_of_the_scan(unit_yaw_deg, ego_mps):
    """At 30 m/s the car is 0.2 m closer or farther when a unit with another yaw measures it."""
    at_once = lead(None, ego_mps)
    assert np.abs(lead(unit_yaw_deg, ego_mps) - at_once).max() < 0.045
    uncorrected = lead(unit_yaw_deg, ego_mps, DeskewConfig(motion="ego"))
    assert np.abs((uncorrected - at_once).mean()) > 0.1


class WithoutTargets(Detector):
    """Compensates ego motion only, and keeps the time offsets of all points."""

    def step(self, scan, _=None, long=None):
        return super().step(scan, None, long)


def test_the_time_of_a_box_compensates_missing_target_deskew():
    """Without deskew of its segment, the box has a time offset that the track update compensates."""
    off = lead(30.0, detector=WithoutTargets(TrackerConfig())) - lead(None)
    assert np.abs(off).max() < 0.03

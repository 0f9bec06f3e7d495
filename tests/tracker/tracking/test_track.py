import numpy as np
import pytest
from support.filter_bank import Filters
from support.one_track import CAR, DT, flow_of, follow, start, straight
from support.seen import observe_boxes

from luxloop.tracker.records import MODELS, Status
from luxloop.tracker.tracking import vehicle_size
from luxloop.tracker.tracking.corner import corner_covariance
from luxloop.tracker.tracking.existence import ExistenceConfig
from luxloop.tracker.tracking.filters import FilterConfig, motion
from luxloop.tracker.tracking.heading import HEADING_REJECTIONS_MAX
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.model_selection import model_selection
from luxloop.tracker.tracking.output import report
from luxloop.tracker.tracking.track_table import empty

SEEN_STD_M = float(np.sqrt(observe_boxes((20.0, 3.5, 0.0), CAR).covariance[0, 0, 0]))
"""Standard deviation of the corner of every box along x and y [m]."""


@pytest.fixture
def sharp_corners(monkeypatch):
    """Cars whose corners hide no part of a side, as those of the observations here."""
    monkeypatch.setattr(vehicle_size, "HIDDEN_M", np.zeros(2))


@pytest.mark.usefixtures("sharp_corners")
def test_a_passing_car_does_not_jump_when_its_nearest_corner_changes():
    """It passes the ego from behind: the tracked corner changes from front to rear."""
    first = (-20.0, 3.5, 0.0)
    track = start(first)
    poses = straight(first, 10.0, 60)
    first_corner = tuple(track.table.corner_sign[0])
    centers = follow(track, poses)
    assert first_corner == (1, -1)
    assert tuple(track.table.corner_sign[0]) == (-1, -1)
    assert np.abs(centers - poses[:, :2])[10:].max() < 0.03


@pytest.mark.usefixtures("sharp_corners")
def test_motion_corrects_a_wrong_initial_heading_without_moving_the_box():
    first = (30.0, 3.5, np.pi)
    poses = straight(first, 8.0, 30)
    track = start(first, flow_of())
    assert track.heading == pytest.approx(0.0, abs=1e-9)
    centers = follow(track, poses)
    assert abs(track.heading) == pytest.approx(np.pi, abs=0.01)
    assert np.abs(centers - poses[:, :2])[5:].max() < 0.05


def test_a_vehicle_that_moved_keeps_its_heading_while_stationary():
    """It approached the ego; stationary and half occluded, its visible extent is wider than long."""
    track = start((20.0, 3.5, np.pi))
    follow(track, straight((20.0, 3.5, np.pi), 8.0, 15))
    x = 20.0 - 8.0 * DT * 15
    follow(track, [(x, 3.5, np.pi)] * 20)
    track.table.visible_size[0] = np.array([2.0, 0.5])
    follow(track, [(x, 3.5, np.pi)] * 3)
    assert abs(track.heading) == pytest.approx(np.pi, abs=0.02)


def test_status_from_tentative_to_dead():
    """A car in full view is confirmed at its third observation."""
    first = (15.0, 2.0, 0.0)
    track = start(first)
    track.settle()
    assert track.status is Status.TENTATIVE
    follow(track, [first])
    assert track.status is Status.TENTATIVE
    follow(track, [first])
    assert track.status is Status.CONFIRMED
    waited = 0
    while track.status is not Status.DEAD:
        track.predict()
        track.settle()
        waited += 1
        assert waited * DT < 20.0
    memory = ExistenceConfig()
    assert waited * DT == pytest.approx(-memory.course_s * np.log(memory.existence_min), abs=DT)


def test_a_tentative_track_is_terminated_early():
    track = start((15.0, 2.0, 0.0))
    for _ in range(3):
        track.predict()
        track.settle()
    assert track.status is Status.DEAD


@pytest.mark.parametrize(("motion", "model"), [("stands", 0), ("drives", 1), ("brakes", 2)])
def test_the_model_that_fits_the_motion_is_selected(motion, model):
    """In most frames after convergence, with the noise of the fit."""
    rng = np.random.default_rng(3)
    time = DT * np.arange(1, 80)
    travelled = {
        "stands": 0 * time,
        "drives": 10 * time,
        "brakes": 10 * np.sin(2 * time),  # 40 m/s^2 peaks: clearly not constant velocity
    }[motion]
    poses = np.stack([20 + travelled, np.full_like(time, 4.0), 0 * time], axis=1)
    track = start((20.0, 4.0, 0.0))
    chosen = []
    for pose in poses:
        follow(track, [pose], rng)
        chosen.append(track.table.model[0])
    assert np.mean(np.array(chosen[20:]) == model) > 0.6


def test_a_heading_outlier_is_rejected_until_it_persists():
    first = (15.0, 4.0, 0.0)
    track = start(first)
    follow(track, [first] * 10)
    follow(track, [(15.0, 4.0, 0.6)])
    assert abs(track.heading) < 0.01
    follow(track, [(15.0, 4.0, 0.6)] * (HEADING_REJECTIONS_MAX + 4))
    assert track.heading == pytest.approx(0.6, abs=0.05)


def test_the_record_of_no_tracks_has_valid_shapes():
    none = report(empty(MODELS), model_selection(MmaConfig()))
    assert (len(none), none.mean.shape, none.model_probability.shape) == (0, (0, 8), (0, len(MODELS)))
    assert none.center_odom.shape == (0, 2)


def test_the_rear_of_a_stationary_car_that_comes_into_view_does_not_turn_it():
    """Its right end is fixed, its left end seems to move at 1.5 m/s until all 1.8 m of the rear are visible."""
    track = start((20.0, 3.5, 0.0), size=(0.2, 0.5))
    for k in range(30):
        width = min(0.5 + 1.5 * DT * k, 1.8)
        follow(track, [(20.0, 3.5 - 0.25 + 0.5 * width, 0.0)], size=(0.2, width))
    assert np.cos(track.heading) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("method", ["mma", "imm", "paper"])
def test_every_method_reports_a_consistent_record(method):
    track = start((20.0, 3.5, 0.0), mma=MmaConfig(method=method))
    follow(track, straight((20.0, 3.5, 0.0), 8.0, 25), np.random.default_rng(1))
    record = track.record
    assert record.mean[0, 2] == pytest.approx(8.0, abs=0.5)
    assert record.model[0] == np.argmax(record.model_probability[0]) == MODELS.index("cv")
    assert np.linalg.eigvalsh(record.covariance[0]).min() > 0
    assert np.linalg.eigvalsh(record.model_covariance_odom[0] - track.table.corner_error[0]).min() > 0
    assert (record.model_nis[0] > 0).all()
    track.predict()
    assert np.isnan(track.record.model_nis).all()


def test_independent_models_are_not_affected_by_mixing():
    """The independent constant velocity filter lags a braking car like a textbook filter with the same input."""
    track, twin = start((20.0, 3.5, 0.0)), None
    speed, x = 12.0, 20.0
    for _ in range(40):
        x, speed = x + speed * DT, speed - 3.0 * DT
        before = track.table.independent_mean[0].copy(), track.table.independent_covariance[0].copy()
        follow(track, [(x, 3.5, 0.0)])
        twin = Filters(*before)
        twin.predict(motion(DT, FilterConfig()).models)
        seen = observe_boxes((x, 3.5, 0.0), CAR)
        twin.correct(seen.corner[0] - twin.mean[:, :2], seen.covariance[0, :2, :2])
    assert track.table.independent_mean[0] == pytest.approx(twin.mean, abs=0.02)
    assert track.table.independent_mean[0][1, 0] - track.position[0] > 0.05


def test_nees_is_chi_square_for_a_time_correlated_error():
    """Tracks whose corner has a constant error, drawn from the boxes' noise, plus independent noise of equal size."""
    rng, nees = np.random.default_rng(5), []
    for _ in range(60):
        constant = rng.normal(0, SEEN_STD_M, 2)
        track = start((20.0 + constant[0], 3.5 + constant[1], 0.0))
        for pose in straight((20.0, 3.5, 0.0), 6.0, 25):
            noise = np.append(constant + rng.normal(0, SEEN_STD_M, 2), 0.0)
            follow(track, [pose + noise])
        corner = pose[:2] + 0.5 * track.table.corner_sign[0] * CAR
        off = track.position - corner
        nees.append(off @ np.linalg.solve(corner_covariance(track.table, 0), off))
    assert np.mean(nees) == pytest.approx(2.0, abs=0.7)  # of a chi-square with 2 degrees: mean 2, std of the mean 0.26

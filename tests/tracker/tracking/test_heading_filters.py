"""Filters of heading and yaw rate, without a track around them."""

import numpy as np
import pytest

from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking import heading as heading_module
from luxloop.tracker.tracking.filters import FilterConfig, motion
from luxloop.tracker.tracking.heading import (
    COURSE_TIME_S,
    HEADING_RESTART_S,
    SLIP_STD_RAD,
    Turn,
    corrected,
    heading_filter,
    near,
    predicted,
    write,
    yaw_rate_std,
)
from luxloop.tracker.tracking.orientation import Course
from luxloop.tracker.tracking.track_table import empty

CONFIG = FilterConfig()
STD = 0.02


class OneHeading:
    """A table of one track, with its heading filter."""

    def __init__(self, heading, variance, method="adaptive"):
        self._filter, self.table = heading_filter(FilterConfig(heading=method)), empty(MODELS, rows=1)
        write(self.table.yaw, self.table.yaw_covariance, 0, Turn.start(heading, variance, 0.0))

    def predict(self, motion, speed_mps, turning):
        self._filter.predict(self.table, motion, np.array([speed_mps]), np.array([turning]))

    def observe(self, heading, variance):
        self._filter.observe(self.table, 0, heading, variance)

    def support(self, direction, variance, dt=0.08):
        self._filter.support(self.table, 0, Course(direction, variance), dt)

    @property
    def state(self):
        return self.table.yaw[0], self.table.yaw_covariance[0]


def follow(found, headings, speed_mps=8.0, dt=0.08, turning=True):
    """Feed headings, one per scan; return the errors after each [rad]."""
    errors = []
    for heading in headings:
        found.predict(motion(dt, CONFIG), speed_mps, turning)
        found.observe(heading, STD**2)
        errors.append(np.angle(np.exp(1j * (found.state[0][0] - heading))))
    return np.array(errors)


def adaptive(heading=0.0):
    return OneHeading(heading, STD**2)


@pytest.mark.parametrize("dt", [0.02, 0.08, 0.25])
def test_the_prior_of_the_yaw_rate_does_not_depend_on_the_rate_of_scans(dt):
    """After many correlation times it is that of curvature times speed, here 0.1 / m x 4 m/s."""
    found = Turn.start(0.0, 0.0, 0.0)
    for _ in range(round(10.0 / dt)):
        found = predicted(found, dt, 4.0)
    assert found.variance[2] == pytest.approx(0.4**2, rel=1e-3)


def test_the_noise_of_a_step_is_that_of_many_small_ones():
    many = Turn.start(0.1, STD**2, 0.5)
    one = predicted(many, 0.25, 6.0)
    for _ in range(1000):
        many = predicted(many, 0.00025, 6.0)
    assert (one.heading, one.yaw_rate) == pytest.approx((many.heading, many.yaw_rate), rel=1e-9)
    assert one.variance == pytest.approx(many.variance, rel=1e-6)


@pytest.mark.parametrize(("speed_mps", "std"), [(0.0, 0.0), (4.0, 0.4), (20.0, 0.2), (40.0, 0.1)])
def test_slow_vehicles_are_limited_by_their_steering_and_fast_ones_by_their_grip(speed_mps, std):
    assert yaw_rate_std(speed_mps) == pytest.approx(std)


def test_an_update_without_outliers_is_that_of_a_kalman_filter(monkeypatch):
    """The share of outliers is negligible; the gain is computed by hand from the covariance before it."""
    monkeypatch.setattr(heading_module, "HEADING_OUTLIER_FRACTION", 1e-6)
    before = predicted(Turn.start(0.0, STD**2, 0.0), 0.08, 8.0)
    p, c, r = before.variance
    found, outlier = corrected(before, 0.01, STD**2)
    gain = p / (p + STD**2)
    assert outlier < 1e-5
    assert found.heading == pytest.approx(0.01 * gain, rel=1e-4)
    assert found.yaw_rate == pytest.approx(0.01 * c / (p + STD**2), rel=1e-4)
    assert found.variance == pytest.approx((p * (1 - gain), c * (1 - gain), r - c**2 / (p + STD**2)), rel=1e-3)


def test_a_measurement_in_doubt_adds_to_the_variance():
    first = Turn.start(0.0, STD**2, 0.0)
    sure, _ = corrected(first, 0.0, STD**2)
    doubtful, probability = corrected(first, 0.11, STD**2)
    assert 0.1 < probability < 0.9
    assert doubtful.variance[0] > 2 * sure.variance[0]


@pytest.mark.parametrize("rate_hz", [4.0, 12.5, 50.0])
def test_one_outlier_has_no_effect_and_lasting_ones_win(rate_hz):
    found, dt = adaptive(), 1.0 / rate_hz
    follow(found, np.zeros(10), speed_mps=0.0, dt=dt)
    follow(found, [0.6], speed_mps=0.0, dt=dt)
    assert abs(found.state[0][0]) < 0.01
    scans = int(HEADING_RESTART_S * rate_hz) + 2
    follow(found, np.full(scans, 0.6), speed_mps=0.0, dt=dt)
    assert found.state[0][0] == pytest.approx(0.6, abs=0.02)
    assert found.state[1][0, 0] < STD**2


def test_a_turn_that_begins_unseen_is_taken_over_with_its_yaw_rate():
    """The heading jumps by 14 degrees and turns on at 1 rad/s: the second filter has learned the turn."""
    found = adaptive()
    follow(found, np.zeros(20))
    errors = follow(found, 0.25 + 0.08 * np.arange(1, 21))
    assert np.abs(errors[-8:]).max() < np.deg2rad(2.0)
    assert found.state[0][1] == pytest.approx(1.0, abs=0.2)


def test_a_stationary_vehicle_does_not_turn_with_its_noise():
    rng = np.random.default_rng(2)
    found = adaptive()
    follow(found, rng.normal(0.0, STD, 200), speed_mps=0.0)
    assert abs(found.state[0][0]) < STD
    assert abs(found.state[0][1]) < np.deg2rad(1.0)


def test_motion_supports_a_heading_that_no_face_shows():
    """Wrong by 3 degrees as a curved rear is, while the vehicle has driven straight for two seconds."""
    found, alone = adaptive(), adaptive()
    for _ in range(60):
        for each in (found, alone):
            each.predict(motion(0.08, CONFIG), 15.0, False)
            each.observe(np.deg2rad(3.0), np.deg2rad(3.0) ** 2)
        found.support(0.0, np.deg2rad(0.5) ** 2)
    assert abs(found.state[0][0]) < 0.6 * abs(alone.state[0][0])


@pytest.mark.parametrize("dt", [0.02, 0.1])
def test_the_supports_of_one_memory_of_the_course_count_as_one_measurement(dt):
    """The direction is a mean over `COURSE_TIME_S`, so that more scans in that time hold no more information."""
    found, course = OneHeading(0.0, 0.01), np.deg2rad(0.5) ** 2
    for _ in range(round(COURSE_TIME_S / dt)):
        found.support(0.0, course, dt)
    once = 1.0 / (1.0 / 0.01 + 1.0 / (course + SLIP_STD_RAD**2))
    assert found.state[1][0, 0] == pytest.approx(once, rel=0.15)


def test_motion_does_not_hold_a_turn_back():
    """The direction of motion lags by half a second."""
    found, rate = adaptive(), 0.6
    for k in range(60):
        found.predict(motion(0.08, CONFIG), 8.0, True)
        found.observe(rate * 0.08 * k, STD**2)
        found.support(rate * (0.08 * k - 0.5), np.deg2rad(0.5) ** 2)
    assert np.angle(np.exp(1j * (found.state[0][0] - rate * 0.08 * 59))) == pytest.approx(0.0, abs=np.deg2rad(2.0))


def test_the_papers_filter_forgets_the_yaw_rate_of_a_vehicle_that_does_not_turn():
    found = OneHeading(0.0, STD**2, "paper")
    follow(found, 0.02 * np.arange(1, 30))
    assert found.state[0][1] > 0.1
    found.predict(motion(0.08, CONFIG), 8.0, False)
    assert found.state[0][1] == 0.0


def test_headings_are_compared_modulo_a_quarter_turn():
    assert near(0.1 + np.pi / 2, 0.0) == pytest.approx(0.1)
    assert near(-3.1, 3.1) == pytest.approx(-3.1 + 2 * np.pi)

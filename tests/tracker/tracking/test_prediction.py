"""Predictions of single models against hand-computed positions."""

import numpy as np
import pytest
from scipy.integrate import quad

from luxloop.tracker.records import MODEL_NAMES, PREDICTION_S
from luxloop.tracker.tracking.output import lasting, position

FOREVER = np.inf


def positions(name, velocity, acceleration=(0.0, 0.0), yaw_rate=0.0, direction=1.0 + 0.0j, mode_time_s=FOREVER):
    """(3, 2) positions after 0.5, 1 and 2 s, of a vehicle that starts at (10, 20)."""
    mean, model = np.array([10.0, 20.0, *velocity, *acceleration]), MODEL_NAMES.index(name)
    shares = [lasting(ahead, mode_time_s) for ahead in PREDICTION_S]
    places = [
        position(model, mean, share, yaw_rate, direction, ahead)
        for share, ahead in zip(shares, PREDICTION_S, strict=True)
    ]
    return np.array([(place.real, place.imag) for place in places])


def test_a_stationary_vehicle_stays():
    assert positions("stationary", (3.0, 1.0), (1.0, 0.0)) == pytest.approx(np.tile([10.0, 20.0], (3, 1)))


def test_constant_velocity_is_straight():
    assert positions("cv", (4.0, -2.0), (9.0, 9.0)) == pytest.approx(np.array([[12, 19], [14, 18], [18, 16]]))


def test_constant_acceleration_is_a_parabola():
    # 4 m/s and 2 m/s^2 along x, 1 m/s^2 along y: 4 t + t^2, t^2 / 2.
    expected = [[10 + 2.25, 20.125], [10 + 5, 20.5], [10 + 12, 22]]
    assert positions("ca", (4.0, 0.0), (2.0, 1.0)) == pytest.approx(np.array(expected))


@pytest.mark.parametrize("name", ["ca", "ctra", "two-axle"])
def test_a_braking_vehicle_stops_and_does_not_reverse(name):
    # 3 m/s and -3 m/s^2: it stops after 1 s and 1.5 m; after 0.5 s it has come 1.5 - 0.375 m.
    found = positions(name, (3.0, 0.0), (-3.0, 0.0))
    assert found == pytest.approx(np.array([[11.125, 20], [11.5, 20], [11.5, 20]]))


@pytest.mark.parametrize("name", ["ca", "ctra", "two-axle"])
def test_a_vehicle_that_reverses_stops_or_goes_on_backwards(name):
    """Its heading is along x in each case; -3 t + 1.5 t^2 until it stands, and -3 t - 1.5 t^2."""
    stops, goes_on = (positions(name, (-3.0, 0.0), (change, 0.0)) for change in (3.0, -3.0))
    assert stops == pytest.approx(np.array([[8.875, 20], [8.5, 20], [8.5, 20]]))
    assert goes_on == pytest.approx(np.array([[8.125, 20], [5.5, 20], [-2, 20]]))


def test_a_constant_turn_is_a_circle():
    # 8 m/s at 0.5 rad/s: a radius of 16 m; after 2 s it has turned by 1 rad.
    expected = [[10 + 16 * np.sin(0.5 * t), 20 + 16 * (1 - np.cos(0.5 * t))] for t in PREDICTION_S]
    assert positions("ctrv", (8.0, 0.0), yaw_rate=0.5) == pytest.approx(np.array(expected))
    assert positions("ctra", (8.0, 0.0), (0.0, 4.0), yaw_rate=0.5) == pytest.approx(np.array(expected))


def test_a_two_axle_vehicle_stays_on_its_circle_when_it_brakes():
    """At constant curvature 1/16 m the way of 8 t - t^2 lies on the circle; a constant turn rate would leave it."""
    way = np.array([8 * t - t**2 for t in PREDICTION_S])
    expected = np.column_stack([10 + 16 * np.sin(way / 16), 20 + 16 * (1 - np.cos(way / 16))])
    assert positions("two-axle", (8.0, 0.0), (-2.0, 4.0), yaw_rate=0.5) == pytest.approx(expected)
    left = positions("ctra", (8.0, 0.0), (-2.0, 4.0), yaw_rate=0.5)[2] - (10.0, 36.0)
    assert np.hypot(*left) < 15.5


def test_a_two_axle_vehicle_moves_along_its_heading_only():
    assert positions("two-axle", (4.0, 3.0))[1] == pytest.approx([14.0, 20.0])


def test_a_path_is_not_tighter_than_a_turning_circle():
    # 1 m/s at 2 rad/s would be a circle of 0.5 m; the limit is 4 m.
    found = positions("two-axle", (1.0, 0.0), yaw_rate=2.0)[1]
    assert found == pytest.approx([10 + 4 * np.sin(0.25), 20 + 4 * (1 - np.cos(0.25))])


def test_an_acceleration_that_may_end_has_its_mean_effect():
    """The double integral of exp(-t / 3 s), by quadrature."""
    for ahead in PREDICTION_S:
        way, _ = quad(lambda t, end=ahead: (end - t) * np.exp(-t / 3.0), 0.0, ahead)
        assert lasting(ahead, 3.0) == pytest.approx(way / (0.5 * ahead**2))
        assert lasting(ahead, FOREVER) == 1.0
        assert lasting(ahead, 1e5) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("name", MODEL_NAMES)
def test_a_vehicle_at_rest_is_predicted_at_its_place(name):
    with np.errstate(all="raise"):
        assert positions(name, (0.0, 0.0), (-1e-9, 0.0), yaw_rate=1e-9) == pytest.approx(
            np.tile([10.0, 20.0], (3, 1)), abs=1e-6
        )

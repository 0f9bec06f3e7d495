"""Attitude of the ego's body: statistics and spectrum."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from support.noise_scenes import BEAMS

from luxloop.sensor_model.noise.attitude import Attitude
from luxloop.sensor_model.noise.noise_config import AttitudeNoise
from luxloop.sensor_model.noise.random_draws import Draws

ON = AttitudeNoise(True, pitch_sigma_deg=0.5, roll_sigma_deg=0.8)
FRAME_S = 0.08
FAST_MPS = 10.0
"""Speed from which the motion is full by default."""


def angles_deg(config, times, seed=3, speed=FAST_MPS):
    """Return (N, 2) pitch and roll [deg]."""
    attitude = Attitude(config, Draws(seed, BEAMS))
    R = np.array([attitude.at(time, speed) for time in times])
    return scipy.spatial.transform.Rotation.from_matrix(R).as_euler("YXZ", degrees=True)[:, :2]


@pytest.mark.parametrize("start", [0.0, 8000.0])
def test_pitch_and_roll_have_their_sigmas_and_no_mean(start):
    """Over 400 s, also after 1e5 frames. The time average of a sum of many cosines is exact up to its ends."""
    angles = angles_deg(ON, start + FRAME_S * np.arange(5000))
    np.testing.assert_allclose(angles.std(axis=0), [0.5, 0.8], rtol=0.08)
    np.testing.assert_allclose(angles.mean(axis=0), 0.0, atol=0.02)
    assert abs(np.corrcoef(angles.T)[0, 1]) < 0.1


def test_attitude_is_gaussian_over_runs():
    """At one instant of 800 runs: variance and kurtosis. Fails if phases are not random."""
    pitch = np.array([angles_deg(ON, [7.0], seed)[0, 0] for seed in range(800)]) / 0.5
    assert abs(pitch.mean()) < 4 / np.sqrt(800)
    assert pitch.std() == pytest.approx(1.0, rel=4 / np.sqrt(1600))
    assert np.mean(pitch**4) == pytest.approx(3.0, abs=4 * np.sqrt(96 / 800))


def test_power_is_uniform_in_the_band():
    pitch = angles_deg(ON, 0.04 * np.arange(20000))[:, 0]
    frequency, density = scipy.signal.welch(pitch, fs=25.0, nperseg=512)
    inside = (frequency > 0.45) & (frequency < 2.55)
    assert density[inside].sum() > 0.99 * density.sum()
    halves = [density[(frequency > low) & (frequency < low + 1.0)].sum() for low in (0.5, 1.5)]
    assert halves[0] == pytest.approx(halves[1], rel=0.25)


def test_motion_is_continuous_and_does_not_repeat():
    """A step of 1 ms rotates the body by at most its fastest rate; a grid of frequencies would repeat after 32 s."""
    times = np.arange(0.0, 3.0, 0.001)
    steps = np.abs(np.diff(angles_deg(ON, times), axis=0)).max(axis=0)
    assert np.all(steps < 2 * np.pi * 2.5 * 0.001 * np.array([0.5, 0.8]) * 4)
    assert np.all(steps > 0.0)
    one, later = (angles_deg(ON, start + FRAME_S * np.arange(300))[:, 0] for start in (0.0, 32.0))
    assert abs(np.corrcoef(one, later)[0, 1]) < 0.5


def test_order_of_frames_does_not_matter():
    attitude = Attitude(ON, Draws(3, BEAMS))
    late, early = attitude.at(80.0, FAST_MPS), attitude.at(0.08, FAST_MPS)
    fresh = Attitude(ON, Draws(3, BEAMS))
    assert np.array_equal(fresh.at(0.08, FAST_MPS), early)
    assert np.array_equal(fresh.at(80.0, FAST_MPS), late)


def test_constant_pitch_is_nose_down_and_constant_roll_right_side_down():
    still = AttitudeNoise(True, pitch_deg=1.0, roll_deg=2.0, pitch_sigma_deg=0.0, roll_sigma_deg=0.0)
    R = Attitude(still, Draws(3, BEAMS)).at(5.0, speed=0.0)
    nose, left = R @ [1.0, 0.0, 0.0], R @ [0.0, 1.0, 0.0]
    assert nose[2] == pytest.approx(-np.sin(np.deg2rad(1.0)))
    assert left[2] == pytest.approx(np.sin(np.deg2rad(2.0)) * np.cos(np.deg2rad(1.0)))


def test_ego_is_level_if_disabled():
    assert np.array_equal(Attitude(AttitudeNoise(False, pitch_deg=1.0), Draws(3, BEAMS)).at(5.0, FAST_MPS), np.eye(3))


def test_a_standing_car_does_not_sway_and_a_slow_one_sways_less():
    """At a quarter of the full speed half of the angles; above the full speed no more."""
    times = FRAME_S * np.arange(100)
    full = angles_deg(ON, times)
    np.testing.assert_allclose(angles_deg(ON, times, speed=0.0), 0.0, atol=1e-12)
    np.testing.assert_allclose(angles_deg(ON, times, speed=2.5), full / 2.0, atol=1e-9)
    np.testing.assert_allclose(angles_deg(ON, times, speed=40.0), full, atol=1e-12)
    constant = replace(ON, full_from_mps=0.0)
    np.testing.assert_allclose(angles_deg(constant, times, speed=0.0), full, atol=1e-12)


def road_pitch_deg(speed, roughness=64e-6, wheelbase=2.8, own_hz=1.5, damping=0.3):
    """Return the standard deviation [deg] of a body's pitch between the two frequencies on a road by ISO 8608.

    The slope between the axles, of spectral density G (n / 0.1)^-2 (2 sin(pi n L) / L)^2, drives a damped oscillator.
    """
    n = np.linspace(0.5, 2.5, 20_001) / speed
    ratio = n * speed / own_hz
    response = (1 + (2 * damping * ratio) ** 2) / ((1 - ratio**2) ** 2 + (2 * damping * ratio) ** 2)
    slope = roughness * (n / 0.1) ** -2.0 * (2.0 * np.sin(np.pi * n * wheelbase) / wheelbase) ** 2
    return np.rad2deg(np.sqrt(np.trapezoid(slope * response, n)))


def test_strength_and_its_dependence_on_speed_are_those_of_a_road():
    assert road_pitch_deg(FAST_MPS) == pytest.approx(0.14, abs=0.005), "class B, as the docstring states"
    for speed in (2.5, 5.0):
        assert road_pitch_deg(speed) / road_pitch_deg(FAST_MPS) == pytest.approx(np.sqrt(speed / FAST_MPS), rel=0.1)
    for speed in (15.0, 20.0, 25.0):
        assert road_pitch_deg(speed) / road_pitch_deg(FAST_MPS) == pytest.approx(1.0, rel=0.25)
    braking = 2.5 / 9.81  # degrees at 1 m/s^2
    assert AttitudeNoise().pitch_sigma_deg == pytest.approx(np.hypot(0.14, braking), abs=0.02)
    assert AttitudeNoise().full_from_mps == FAST_MPS

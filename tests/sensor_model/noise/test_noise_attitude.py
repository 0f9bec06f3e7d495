"""Attitude of the ego's body: statistics and spectrum."""

import numpy as np
import pytest
import scipy
from support.noise_scenes import BEAMS

from sensor_model.noise.attitude import Attitude
from sensor_model.noise.noise_config import AttitudeNoise
from sensor_model.noise.random_draws import Draws

ON = AttitudeNoise(True, pitch_sigma_deg=0.5, roll_sigma_deg=0.8)
FRAME_S = 0.08


def angles_deg(config, times, seed=3):
    """Return (N, 2) pitch and roll [deg]."""
    attitude = Attitude(config, Draws(seed, BEAMS))
    R = np.array([attitude.at(time) for time in times])
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
    late, early = attitude.at(80.0), attitude.at(0.08)
    fresh = Attitude(ON, Draws(3, BEAMS))
    assert np.array_equal(fresh.at(0.08), early)
    assert np.array_equal(fresh.at(80.0), late)


def test_constant_pitch_is_nose_down_and_constant_roll_right_side_down():
    still = AttitudeNoise(True, pitch_deg=1.0, roll_deg=2.0, pitch_sigma_deg=0.0, roll_sigma_deg=0.0)
    R = Attitude(still, Draws(3, BEAMS)).at(5.0)
    nose, left = R @ [1.0, 0.0, 0.0], R @ [0.0, 1.0, 0.0]
    assert nose[2] == pytest.approx(-np.sin(np.deg2rad(1.0)))
    assert left[2] == pytest.approx(np.sin(np.deg2rad(2.0)) * np.cos(np.deg2rad(1.0)))


def test_ego_is_level_if_disabled():
    assert np.array_equal(Attitude(AttitudeNoise(pitch_deg=1.0), Draws(3, BEAMS)).at(5.0), np.eye(3))

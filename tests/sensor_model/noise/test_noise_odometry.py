"""Dead reckoning: exact without noise, and with the configured errors."""

import numpy as np
import pytest
from support.few import few

from luxloop.sensor_model.noise.odometry_drift import OdometryNoise
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.odometry import Odometry
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import load_rig

DT = 0.08


@pytest.fixture(scope="module")
def draws(tmp_path_factory):
    beams = beam_table(load_rig("srx_six_lux", tmp_path_factory.mktemp("rig")))
    return lambda seed: Draws(seed, beams)


def arc(frames, speed=10.0, yaw_rate=0.2):
    """Return poses (K, 3) on a circle, far from the origin of the world."""
    time = DT * np.arange(frames)
    yaw = 1.0 + yaw_rate * time
    radius = speed / yaw_rate
    return np.stack([500 + radius * np.sin(yaw), -300 - radius * np.cos(yaw), yaw], axis=1), time


def driven(odometry, poses, time):
    return np.array([odometry.pose(pose, t, k) for k, (pose, t) in enumerate(zip(poses, time, strict=True))])


def test_accumulated_pose_is_exact_without_errors(draws):
    """A curve reveals a wrong frame or order of accumulation."""
    poses, time = arc(400)
    none = OdometryNoise(enabled=True, speed_scale_sigma=0.0, yaw_rate_sigma_dps=0.0, yaw_walk_sigma_deg=0.0)
    summed = driven(Odometry(none, draws(1)), poses, time)
    exact = driven(Odometry(OdometryNoise(enabled=False), draws(1)), poses, time)
    assert summed == pytest.approx(exact, abs=1e-9)


def test_distances_have_a_constant_scale_error_over_a_run(draws):
    time = DT * np.arange(5)
    poses = np.stack([10.0 * time, 0 * time, 0 * time], axis=1)
    noise = OdometryNoise(enabled=True, yaw_rate_sigma_dps=0.0, yaw_walk_sigma_deg=0.0)
    factor = []
    for seed in range(150):
        way = driven(Odometry(noise, draws(seed)), poses, time)
        step = np.linalg.norm(np.diff(way[:, :2], axis=0), axis=1)
        assert np.ptp(step) < 1e-9
        factor.append(step[0] / (10.0 * DT))
    assert np.std(factor) == pytest.approx(noise.speed_scale_sigma, rel=0.2)


def test_scale_error_stretches_the_whole_way_in_a_bend(draws):
    poses, time = arc(200, yaw_rate=0.6)
    noise = OdometryNoise(enabled=True, speed_scale_sigma=0.05, yaw_rate_sigma_dps=0.0, yaw_walk_sigma_deg=0.0)
    found = driven(Odometry(noise, draws(3)), poses, time)
    exact = driven(Odometry(OdometryNoise(enabled=False), draws(3)), poses, time)
    factor = np.linalg.norm(found[1, :2]) / np.linalg.norm(exact[1, :2])
    assert abs(factor - 1.0) > 0.001
    assert found == pytest.approx(exact * [factor, factor, 1.0], abs=1e-9)


@pytest.mark.parametrize("dt", few([DT, 0.32, 1.0], 0.32))
@pytest.mark.parametrize(("bias_dps", "walk_deg"), [(0.05, 0.0), (0.0, 0.2), (0.05, 0.2)])
def test_yaw_drift_has_bias_and_random_walk(draws, dt, bias_dps, walk_deg):
    """Variance after t seconds, in steps of any length: (bias t)^2 + walk^2 t."""
    time = dt * np.arange(round(8.0 / dt) + 1)
    noise = OdometryNoise(enabled=True, yaw_rate_sigma_dps=bias_dps, yaw_walk_sigma_deg=walk_deg)
    poses = np.zeros((len(time), 3))
    yaw = np.degrees([driven(Odometry(noise, draws(seed)), poses, time)[-1, 2] for seed in range(150)])
    assert np.std(yaw) == pytest.approx(np.sqrt((bias_dps * 8) ** 2 + walk_deg**2 * 8), rel=0.2)


def test_invalid_noise_is_refused():
    with pytest.raises(ValueError, match="yaw_walk_sigma_deg"):
        OdometryNoise(yaw_walk_sigma_deg=-1.0)

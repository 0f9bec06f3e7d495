import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tracker.filters import Bank, FilterConfig, integrator, motion, process_noise

CONFIG = FilterConfig()
R = np.diag([0.1**2, 0.2**2])


def bank(position=(1.0, 2.0)):
    return Bank(np.array(position), 0.3, np.diag([0.04, 0.04, 0.01]), CONFIG)


def off(kalman, z):
    """(M, 2) pre-fit residuals of a measured corner."""
    return np.stack([z - kf.x[:2] for kf in kalman.models])


def test_integrator_moves_a_constant_acceleration_exactly():
    dt = 0.7
    position, velocity, acceleration = 3.0, -2.0, 4.0
    moved = integrator(3, dt) @ [position, velocity, acceleration]
    assert moved == pytest.approx(
        [position + velocity * dt + acceleration * dt**2 / 2, velocity + acceleration * dt, acceleration]
    )


def test_process_noise_of_constant_velocity_is_the_textbook_one():
    # Bar-Shalom, Li, Kirubarajan (2001), eq. 6.3.2-4: sigma^2 [[dt^4/4, dt^3/2], [dt^3/2, dt^2]].
    dt, variance = 0.5, CONFIG.acceleration_std_mps2**2
    expected = variance * np.array([[dt**4 / 4, dt**3 / 2], [dt**3 / 2, dt**2]])
    assert process_noise(2, dt, CONFIG) == pytest.approx(expected)


def test_log_likelihood_includes_the_measurement_noise():
    kalman = bank()
    kalman.predict(motion(0.08, CONFIG))
    z = np.array([1.4, 1.7])
    expected = [multivariate_normal(kf.x[:2], kf.H @ kf.P @ kf.H.T + R).logpdf(z) for kf in kalman.models]
    assert kalman.log_likelihood(off(kalman, z), R) == pytest.approx(expected)


@pytest.mark.parametrize(("model", "order"), [(0, 1), (1, 2), (2, 3)])
def test_each_filter_follows_its_own_motion_exactly(model, order):
    """Noise-free motion of the filter's own kind is predicted to the millimetre after two seconds."""
    chain = np.array([[5.0, -3.0], [8.0, 2.0], [1.5, -0.5]])[:order]
    dt, kalman = 0.08, bank(chain[0])
    for _ in range(50):
        chain = integrator(order, dt) @ chain
        kalman.predict(motion(dt, CONFIG))
        if _ < 49:
            kalman.update(off(kalman, chain[0]), R * 1e-4)
    assert kalman.models[model].x[:2] == pytest.approx(chain[0], abs=2e-3)


def test_update_equals_a_kalman_filter_written_out():
    kalman, z = bank(), np.array([1.2, 2.1])
    kalman.predict(motion(0.08, CONFIG))
    expected = []
    for kf in kalman.models:
        gain = kf.P @ kf.H.T @ np.linalg.inv(kf.H @ kf.P @ kf.H.T + R)
        expected.append((kf.x + gain @ (z - kf.H @ kf.x), (np.eye(kf.dim_x) - gain @ kf.H) @ kf.P))
    kalman.update(off(kalman, z), R)
    for kf, (mean, covariance) in zip(kalman.models, expected, strict=True):
        assert kf.x == pytest.approx(mean)
        assert pytest.approx(covariance) == kf.P


def test_shift_moves_the_point_and_keeps_the_motion():
    kalman = bank()
    kalman.models[2].x[2:] = [3, 4, 5, 6]
    kalman.shift(np.array([1.0, -2.0]))
    for kf in kalman.models:
        assert kf.x[:2] == pytest.approx([2.0, 0.0])
    assert kalman.models[2].x[2:] == pytest.approx([3, 4, 5, 6])


def test_noise_floors_must_be_positive():
    with pytest.raises(ValueError, match="position_std_floor_m"):
        FilterConfig(position_std_floor_m=0.0)

import numpy as np
import pytest
from support.filter_bank import Filters

from luxloop.tracker.tracking.filters import (
    INITIAL_YAW_RATE_STD_RADPS,
    MANOEUVRE_STD_MPS2,
    STARTING_SPEED_STD_MPS,
    FilterConfig,
    initial_filters,
    integrator,
    motion,
    moved,
    process_noise,
)

CONFIG = FilterConfig()
R = np.array([[0.1**2, 0.003], [0.003, 0.2**2]])
P0 = np.diag([0.04, 0.04])


def started(position=(1.0, 2.0)):
    return Filters(*initial_filters(np.array(position), P0, CONFIG))


def filterpy_twins(filters):
    """The same filters by filterpy."""
    from filterpy.kalman import KalmanFilter

    twins = []
    for mean, covariance in zip(filters.mean, filters.covariance, strict=True):
        kf = KalmanFilter(dim_x=6, dim_z=2)
        kf.x, kf.P, kf.H, kf.R = mean.copy(), covariance.copy(), np.eye(2, 6), R
        twins.append(kf)
    return twins


def test_the_integrator_predicts_constant_acceleration_exactly():
    dt = 0.7
    position, velocity, acceleration = 3.0, -2.0, 4.0
    predicted = integrator(3, dt) @ [position, velocity, acceleration]
    assert predicted == pytest.approx(
        [position + velocity * dt + acceleration * dt**2 / 2, velocity + acceleration * dt, acceleration]
    )


@pytest.mark.parametrize("yaw_rate", [0.7, -0.4, 0.0])
def test_another_point_of_a_turning_body_has_the_motion_of_a_rigid_one(yaw_rate):
    """Difference of two points of a body, and its two derivatives by small steps."""
    offset, step = np.array([4.2, -1.7]), 1e-3
    away = complex(*offset) * np.exp(1j * yaw_rate * step * np.arange(-1, 2))
    velocity, acceleration = (away[2] - away[0]) / (2 * step), (away[2] - 2 * away[1] + away[0]) / step**2
    expected = [*offset, velocity.real, velocity.imag, acceleration.real, acceleration.imag]
    assert moved(offset, yaw_rate) == pytest.approx(expected, abs=1e-5)


def test_process_noise_of_constant_velocity_equals_the_textbook():
    # Bar-Shalom, Li, Kirubarajan (2001), eq. 6.2.2-12: q [[dt^3/3, dt^2/2], [dt^2/2, dt]].
    dt, q = 0.5, 0.3
    assert process_noise(2, dt, q) == pytest.approx(q * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]))


@pytest.mark.parametrize("order", [2, 3])
def test_process_noise_is_that_of_filterpy(order):
    from filterpy.common import Q_continuous_white_noise

    for dt in (0.04, 0.08, 0.37):
        assert process_noise(order, dt, 0.7) == pytest.approx(Q_continuous_white_noise(order, dt, 0.7), rel=1e-15)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_process_noise_does_not_depend_on_the_step_size(order):
    """Ten short steps equal a long one, unlike with noise that is white from step to step."""
    short, noise = integrator(order, 0.1), np.zeros((order, order))
    for _ in range(10):
        noise = short @ noise @ short.T + process_noise(order, 0.1, 0.7)
    assert noise == pytest.approx(process_noise(order, 1.0, 0.7))


def test_a_run_of_the_bank_equals_filterpy():
    """The batch equals filterpy over forty steps with noisy measurements."""
    rng, filters = np.random.default_rng(4), started()
    twins, step = filterpy_twins(filters), motion(0.08, CONFIG)
    for _ in range(40):
        filters.predict(step.models)
        z = rng.normal([1.0, 2.0], 2.0)
        filters.correct(z - filters.mean[:, :2], R)
        for m, kf in enumerate(twins):
            kf.predict(F=step.models.transition[m], Q=step.models.noise[m])
            kf.update(z)
    assert filters.mean == pytest.approx(np.array([kf.x for kf in twins]), abs=1e-9)
    assert filters.covariance == pytest.approx(np.array([kf.P for kf in twins]), abs=1e-9)


@pytest.mark.parametrize(("model", "order"), [(0, 1), (1, 2), (2, 3)])
def test_each_filter_predicts_its_own_motion_exactly(model, order):
    """Noise-free motion of the filter's own kind is predicted to the millimetre after four seconds."""
    chain = np.array([[5.0, -3.0], [8.0, 2.0], [1.5, -0.5]])[:order]
    dt, filters = 0.08, started(chain[0])
    for k in range(50):
        chain = integrator(order, dt) @ chain
        filters.predict(motion(dt, CONFIG).models)
        if k < 49:
            filters.correct(chain[0] - filters.mean[:, :2], R * 1e-6)
    assert filters.mean[model, :2] == pytest.approx(chain[0], abs=2e-3)


def test_omitted_states_have_a_constant_prior_covariance():
    """A velocity kept by the stationary model would affect the models that mix with it."""
    filters = Filters(np.ones((3, 6)), np.tile(np.eye(6), (3, 1, 1)))
    filters.predict(motion(0.08, CONFIG).models)
    assert filters.mean[0, 2:] == pytest.approx(np.zeros(4))
    assert filters.mean[1, 4:] == pytest.approx(np.zeros(2))
    assert np.diag(filters.covariance[0])[2:4] == pytest.approx(STARTING_SPEED_STD_MPS**2)
    assert np.diag(filters.covariance[1])[4:] == pytest.approx(MANOEUVRE_STD_MPS2**2)
    assert filters.covariance[1, :4, 4:] == pytest.approx(np.zeros((4, 2)))


def test_heading_filter_learns_a_turn():
    heading = Filters(np.zeros((1, 2)), np.diag([0.02**2, INITIAL_YAW_RATE_STD_RADPS**2])[None])
    for k in range(1, 60):
        heading.predict(motion(0.08, CONFIG).heading)
        heading.correct(np.array([[0.5 * 0.08 * k]]) - heading.mean[:, :1], np.array([[0.02**2]]))
    assert heading.mean[0] == pytest.approx([0.5 * 0.08 * 59, 0.5], abs=0.02)


def test_invalid_noise_is_rejected():
    with pytest.raises(ValueError, match="position_std_floor_m"):
        FilterConfig(position_std_floor_m=0.0)
    with pytest.raises(ValueError, match="jerk_std_mps3"):
        FilterConfig(jerk_std_mps3=0.0)

"""Turning models against circles, numerical integration, and the straight models."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from luxloop.tracker.tracking.filters import FilterConfig, integrator, motion
from luxloop.tracker.tracking.turning import (
    SMALL_ANGLE,
    Turn,
    axle_to_corner,
    motion_direction,
    real,
    transition_of,
    turned_integrals,
    with_turn,
)

RATE = 0.5
ALL = FilterConfig(models=("stationary", "cv", "ca", "ctrv", "ctra", "two-axle"))


def turn(rate=RATE, velocity=8.0 + 0.0j, direction=1.0 + 0.0j):
    return Turn(rate, 0.02**2, 0.01**2, velocity, direction)


def test_constant_turn_moves_on_a_circle():
    # 8 m/s at 0.5 rad/s: a circle of 16 m radius; after pi seconds a quarter turn.
    state = transition_of("ctrv", turn(), np.pi) @ [0.0, 0.0, 8.0, 0.0, 0.0, 0.0]
    assert state[:2] == pytest.approx([16.0, 16.0])
    assert state[2:4] == pytest.approx([0.0, 8.0], abs=1e-12)
    assert state[4:] == pytest.approx([-4.0, 0.0])  # centripetal: v^2 / r = 64 / 16


@pytest.mark.parametrize("rate", [0.9 * SMALL_ANGLE, -0.9 * SMALL_ANGLE, 1.1 * SMALL_ANGLE, 2.0])
def test_integrals_over_a_turn_equal_quadrature(rate):
    """Below the small angle by their series, above it by their closed form."""
    for power, found in enumerate(turned_integrals(rate, 1.0)):
        expected = quad(lambda t, p=power: t**p * np.exp(1j * rate * t), 0.0, 1.0, complex_func=True)[0]
        assert found == pytest.approx(expected, rel=1e-9)


def test_accelerated_turn_equals_numerical_integration():
    """The speed grows by 1.5 m/s^2 while the velocity turns: integrated by an independent solver."""

    def slope(t, _):
        speed, angle = 8.0 + 1.5 * t, 0.3 + RATE * t
        return [speed * np.cos(angle), speed * np.sin(angle)]

    def state(t):
        speed, angle = 8.0 + 1.5 * t, np.exp(1j * (0.3 + RATE * t))
        velocity, acceleration = speed * angle, (1.5 + 1j * RATE * speed) * angle
        return [velocity.real, velocity.imag, acceleration.real, acceleration.imag]

    end = 1.7
    way = solve_ivp(slope, (0.0, end), [0.0, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    moved = transition_of("ctra", turn(), end) @ [0.0, 0.0, *state(0.0)]
    assert moved == pytest.approx([*way, *state(end)], abs=1e-8)


@pytest.mark.parametrize(("name", "order"), [("ctrv", 2), ("ctra", 3)])
@pytest.mark.parametrize("rate", [0.0, 1e-7, -1e-7])
def test_without_a_turn_the_models_are_straight(name, order, rate):
    straight = np.zeros((3, 3))
    straight[:order, :order] = integrator(order, 0.08)
    assert transition_of(name, turn(rate), 0.08) == pytest.approx(np.kron(straight, np.eye(2)), abs=1e-6)


def test_two_axle_velocity_has_the_direction_of_the_body():
    moved = transition_of("two-axle", turn(), 0.0) @ [1.0, 2.0, 8.0, 3.0, 0.0, 4.0]
    assert moved[:2] == pytest.approx([1.0, 2.0])
    assert moved[2:4] == pytest.approx([8.0, 0.0])
    # The acceleration across is that of the turn of the remaining velocity: 0.5 x 8; along it is 0 + 0.5 x 3.
    assert moved[4:] == pytest.approx([1.5, 4.0])


def test_corner_of_a_turning_body_moves_across_its_heading():
    """The front left corner of a 4.5 m car, 3.6 m ahead of its axle and 0.9 m to the left."""
    from_axle = axle_to_corner(np.array([1, 1]), np.array([4.5, 1.8]))
    assert from_axle == pytest.approx(3.6 + 0.9j)
    # The axle moves at 8 m/s along x, the corner at (8 - 0.5 x 0.9, 0.5 x 3.6).
    expected = np.array([7.55, 1.8])
    found = motion_direction(complex(*expected), 0.0, RATE, from_axle)
    assert [found.real, found.imag] == pytest.approx(expected / np.linalg.norm(expected))


@pytest.mark.parametrize("velocity", [0.0j, 0.1 + 0.0j])
def test_a_slow_vehicle_has_the_direction_of_its_heading(velocity):
    assert motion_direction(velocity, np.pi / 2, 0.0, 3.6 + 0.9j) == pytest.approx(1j)


def test_reversing_has_the_direction_of_the_front():
    """The direction is that of a positive speed, so that the speed along it is negative."""
    found = motion_direction(-3.0 + 0.0j, 0.0, 0.0, 3.6 + 0.9j)
    assert found == pytest.approx(1.0)


def test_only_turning_models_change():
    base = motion(0.08, ALL)
    turned = with_turn(base, turn())
    assert (turned.models.transition[:3] == base.models.transition[:3]).all()
    assert (turned.models.noise[:3] == base.models.noise[:3]).all()
    for m in range(3, 6):
        assert not np.allclose(turned.models.transition[m], base.models.transition[m])
        assert np.linalg.eigvalsh(turned.models.noise[m]).min() > -1e-12
    # The error of the yaw rate turns the velocity of 8 m/s: (0.08 x 8 x 0.02)^2 across it.
    added = turned.models.noise[3] - base.models.noise[3]
    assert added[3, 3] == pytest.approx((0.08 * 8.0 * 0.02) ** 2)
    assert added[2, 2] == pytest.approx(0.0, abs=1e-15)


def test_real_matrix_multiplies_like_the_complex_one():
    rng = np.random.default_rng(3)
    matrix, vector = (
        rng.normal(size=(3, 3)) + 1j * rng.normal(size=(3, 3)),
        rng.normal(size=3) + 1j * rng.normal(size=3),
    )
    flat = np.column_stack([vector.real, vector.imag]).ravel()
    product = matrix @ vector
    assert real(matrix) @ flat == pytest.approx(np.column_stack([product.real, product.imag]).ravel())

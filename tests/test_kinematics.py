"""Differenced rates, held against motions whose rates are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.kinematics import JUMP_SPEED, PoseDifferencer, wrap_angle

DT = 0.08


def rates(differencer, *rows):
    """Feed one frame of (id, x, y, yaw, speed)."""
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return differencer.add(table[:, 0].astype(np.int64), table[:, 1:4], table[:, 4])


@given(st.floats(-1e3, 1e3))
def test_wrapped_angles_lie_in_the_half_open_interval_and_point_the_same_way(angle):
    wrapped = wrap_angle(np.array([angle]))[0]
    assert -np.pi < wrapped <= np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-9)


def test_half_a_turn_is_plus_pi():
    assert list(wrap_angle(np.array([np.pi, -np.pi]))) == [np.pi, np.pi]


def test_a_first_frame_takes_the_simulator_s_speed_along_the_heading():
    first = rates(PoseDifferencer(DT), (0, 5.0, 5.0, np.pi / 2, 7.0))
    assert first.velocity_world[0] == pytest.approx([0.0, 7.0])
    assert first.acceleration_world[0] == pytest.approx([0.0, 0.0])
    assert first.yaw_rate[0] == 0.0


def test_backward_differences_of_a_quadratic_motion():
    # x = 3 t^2: v over a step is 3 (2 t - dt), a is 6 whatever the step; it takes three poses
    differencer = PoseDifferencer(DT)
    frames = [rates(differencer, (4, 3 * t * t, 0.0, 0.0, 6 * t)) for t in np.arange(4) * DT]
    assert [frame.velocity_world[0, 0] for frame in frames[1:]] == pytest.approx([3 * DT, 9 * DT, 15 * DT])
    assert [frame.acceleration_world[0, 0] for frame in frames] == pytest.approx([0.0, 0.0, 6.0, 6.0])


def test_yaw_rate_across_the_half_turn():
    differencer = PoseDifferencer(DT)
    rates(differencer, (1, 0.0, 0.0, np.pi - 0.01, 0.0))
    assert rates(differencer, (1, 0.0, 0.0, -np.pi + 0.03, 0.0)).yaw_rate[0] == pytest.approx(0.04 / DT)


def test_an_actor_that_was_away_starts_anew():
    differencer = PoseDifferencer(DT)
    rates(differencer, (1, 0.0, 0.0, 0.0, 10.0), (2, 0.0, 5.0, 0.0, 0.0))
    rates(differencer, (2, 0.0, 5.0, 0.0, 0.0))
    back = rates(differencer, (1, 1.6, 0.0, 0.0, 10.0), (2, 0.0, 5.0, 0.0, 0.0))
    assert back.velocity_world[0] == pytest.approx([10.0, 0.0])  # not 20: the gap is two frames wide
    assert back.velocity_world[1] == pytest.approx([0.0, 0.0])


def test_rows_are_matched_by_id_when_others_come_and_go():
    differencer = PoseDifferencer(DT)
    rates(differencer, (3, 30.0, 0.0, 0.0, 1.0), (7, 70.0, 0.0, 0.0, 1.0))
    frame = rates(differencer, (1, 0.0, 0.0, 0.0, 9.0), (7, 70.08, 0.0, 0.0, 1.0), (8, 80.0, 0.0, 0.0, 2.0))
    assert frame.velocity_world[:, 0] == pytest.approx([9.0, 1.0, 2.0])


@pytest.mark.parametrize("jump", [(200.0, 0.0), (0.0, 3.2)], ids=["teleport", "lane change in one step"])
def test_a_jump_is_no_velocity_and_leaves_no_acceleration_behind(jump):
    differencer = PoseDifferencer(DT)
    frames = []
    for n in range(6):
        shift = np.array(jump) * (n >= 3)
        frames.append(rates(differencer, (1, 1.6 * n + shift[0], shift[1], 0.0, 20.0)))
    assert np.hypot(*jump) / DT > 20.0 + JUMP_SPEED
    for frame in frames:
        assert frame.velocity_world[0] == pytest.approx([20.0, 0.0])
        assert frame.acceleration_world[0] == pytest.approx([0.0, 0.0])


def test_an_empty_road_is_no_trouble():
    differencer = PoseDifferencer(DT)
    assert rates(differencer).velocity_world.shape == (0, 2)
    assert rates(differencer, (0, 0.0, 0.0, 0.0, 1.0)).velocity_world[0, 0] == 1.0
    assert rates(differencer).yaw_rate.shape == (0,)

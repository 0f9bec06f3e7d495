"""Pitch, roll and lean against closed forms of textbooks and an independent integration."""

import math
from pathlib import Path

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from luxloop.sim.scripted.motions import Arc, Straight
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.suspension import GRAVITY, LEAN_LAG_S, RIDERS, SPRUNG, Suspension
from luxloop.sim.world import Kind

DT = 0.08
BRAKING = -4.0


def respond(kind, accelerations, dt=DT, yaw=0.0):
    """Return the attitudes (T, 2) of one body under accelerations (T, 2), ahead and to the left [m/s^2]."""
    suspension, cos, sin = Suspension(dt), math.cos(yaw), math.sin(yaw)
    turned = np.asarray(accelerations, dtype=float) @ np.array([[cos, sin], [-sin, cos]])
    one, kinds, yaws = np.array([0]), np.array([kind]), np.array([yaw])
    return np.array([suspension.attitude(one, kinds, yaws, now[None])[0] for now in turned])


def braking(dt, seconds=8.0, rise_s=0.08):
    """Return the times, and accelerations that fall to -4 m/s^2 over `rise_s` after 0.96 s."""
    time = np.arange(round(seconds / dt) + 1) * dt
    return time, np.column_stack([BRAKING * np.clip((time - 0.96) / rise_s, 0.0, 1.0), np.zeros(len(time))])


@pytest.mark.parametrize(
    ("kind", "height", "wheelbase", "frequency", "anti_dive"),
    [
        (Kind.CAR, 0.55, 2.7, 1.3, 0.2),
        (Kind.SUV, 0.70, 2.75, 1.25, 0.2),
        (Kind.VAN, 0.70, 3.2, 1.4, 0.0),
        (Kind.TRUCK, 1.1, 4.8, 1.7, 0.0),
        (Kind.TRAILER_TRUCK, 1.8, 7.7, 1.6, 0.0),
        (Kind.BUS, 1.0, 6.0, 1.2, 0.0),
    ],
)
def test_pitch_gradients_follow_from_springs_and_wheelbase(kind, height, wheelbase, frequency, anti_dive):
    """Two springs (2 pi f)^2 m / 2 at L / 2: the moment m a h turns the body by a h / (pi f L)^2."""
    stiffness = 2.0 * 0.5 * (2.0 * math.pi * frequency) ** 2 * (wheelbase / 2.0) ** 2  # per kg
    hand = math.degrees(GRAVITY * height * (1.0 - anti_dive) / stiffness)
    assert SPRUNG[kind].pitch_deg_per_g == pytest.approx(hand, abs=0.06)


def test_car_under_4_mps2_settles_at_the_hand_value_after_the_textbook_overshoot():
    """2.0 degrees per g give 0.815 degrees; a damping ratio z overshoots a step by exp(-pi z / sqrt(1 - z^2)), 37 %."""
    gradient, _, frequency, z = SPRUNG[Kind.CAR]
    time, acceleration = braking(0.005, rise_s=0.005)
    pitch_deg = np.degrees(respond(Kind.CAR, acceleration, 0.005))[:, 0]
    settled = gradient * 4.0 / 9.81
    assert settled == pytest.approx(0.815, abs=1e-3)
    assert pitch_deg[-1] == pytest.approx(settled, rel=1e-4)
    overshoot = math.exp(-math.pi * z / math.sqrt(1.0 - z * z))
    assert pitch_deg.max() / settled - 1.0 == pytest.approx(overshoot, abs=2e-3)
    half_period = 0.5 / (frequency * math.sqrt(1.0 - z * z))
    assert time[pitch_deg.argmax()] - 0.96 == pytest.approx(half_period, abs=0.006)


@pytest.mark.parametrize("kind", [*SPRUNG, *RIDERS])
def test_attitude_does_not_depend_on_the_frame_rate(kind):
    """Settled angles that are linear between coarse frames: of riders, at g tan of a linear function."""
    inputs = [braking(dt)[1] for dt in (DT, DT / 2.0)]
    if kind in RIDERS:
        inputs = [GRAVITY * np.tan(acceleration / GRAVITY) for acceleration in inputs]
    for swapped in (1, -1):
        coarse, fine = (respond(kind, a[:, ::swapped], dt) for a, dt in zip(inputs, (DT, DT / 2.0), strict=True))
        assert coarse == pytest.approx(fine[::2], abs=1e-12)


@given(
    kind=st.sampled_from([*SPRUNG]),
    accelerations=st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=2, max_size=8),
)
def test_motion_solves_the_differential_equation(kind, accelerations):
    """Independent oracle: scipy's integration of the oscillator under linearly interpolated acceleration."""
    pitch_deg, roll_deg, frequency, z = SPRUNG[kind]
    gradient, w = np.radians([-pitch_deg, roll_deg]) / GRAVITY, 2.0 * math.pi * frequency
    time, driving = np.arange(len(accelerations)) * DT, np.array(accelerations) * gradient

    def rates(t, state):
        u = [np.interp(t, time, driving[:, axis]) for axis in (0, 1)]
        return [*state[2:], *(w * w * (u - state[:2]) - 2.0 * z * w * state[2:])]

    state = np.array([*driving[0], 0.0, 0.0])
    for begin in time[:-1]:
        state = scipy.integrate.solve_ivp(rates, (begin, begin + DT), state, rtol=1e-9, atol=1e-12).y[:, -1]
    assert respond(kind, accelerations)[-1] == pytest.approx(state[:2], abs=1e-7)


@pytest.mark.parametrize("kind", list(SPRUNG))
def test_front_goes_down_when_braking_and_right_side_in_a_turn_to_the_left(kind):
    for yaw in (0.0, 2.0):
        assert respond(kind, [[BRAKING, 0.0]], yaw=yaw)[0] == pytest.approx(
            [math.radians(SPRUNG[kind].pitch_deg_per_g) * 4.0 / GRAVITY, 0.0], abs=1e-12
        )
        pitch, roll = respond(kind, [[0.0, 3.0]], yaw=yaw)[0]
        assert pitch == pytest.approx(0.0, abs=1e-12)
        assert roll == pytest.approx(math.radians(SPRUNG[kind].roll_deg_per_g) * 3.0 / GRAVITY)


@pytest.mark.parametrize("kind", RIDERS)
def test_riders_lean_into_a_turn_by_speed_and_radius(kind):
    """At 8 m/s on a radius of 15 m, atan(v^2 / (r g)) = 23.5 degrees, to the left in a turn to the left."""
    turn = 8.0**2 / 15.0
    lean_deg = np.degrees(respond(kind, [[0.0, turn]] * 3))
    assert lean_deg[-1] == pytest.approx([0.0, -math.degrees(math.atan(8.0**2 / (15.0 * 9.81)))])
    assert lean_deg[-1, 1] == pytest.approx(-23.5, abs=0.05)


def test_riders_follow_with_a_first_order_lag():
    dt = 0.001
    step = np.column_stack([np.zeros(2000), np.r_[np.zeros(1), np.full(1999, 3.0)]])
    lean = respond(Kind.BICYCLE, step, dt)[:, 1] / -math.atan(3.0 / GRAVITY)
    assert np.interp(LEAN_LAG_S, np.arange(2000) * dt, lean) == pytest.approx(1.0 - math.exp(-1.0), abs=2e-3)


@pytest.mark.parametrize("kind", [Kind.PEDESTRIAN, Kind.OBSTACLE])
def test_pedestrians_and_obstacles_stay_upright(kind):
    assert not respond(kind, [[-3.0, 2.0], [5.0, 1.0]]).any()


def test_bodies_do_not_depend_on_each_other():
    """Bodies come and go; each has the attitude that it has alone, and starts settled when it returns."""
    rng = np.random.default_rng(4)
    suspension, alone = Suspension(DT), {}
    kinds = rng.integers(len(Kind), size=12)
    for _ in range(60):
        id = np.flatnonzero(rng.uniform(size=12) < 0.8)
        acceleration, yaw = rng.normal(0.0, 3.0, (len(id), 2)), rng.uniform(-3.0, 3.0, len(id))
        found = suspension.attitude(id, kinds[id], yaw, acceleration)
        for row, one in enumerate(id.tolist()):
            own = alone.setdefault(one, Suspension(DT))
            expected = own.attitude(
                id[row : row + 1], kinds[id][row : row + 1], yaw[row : row + 1], acceleration[[row]]
            )
            assert found[row].tobytes() == expected[0].tobytes()
        alone = {one: alone[one] for one in id.tolist()}


def test_unphysical_acceleration_is_limited_to_grip():
    assert np.degrees(respond(Kind.CAR, [[-80.0, 0.0]]))[0, 0] == pytest.approx(2.0)


def scripted_frame(*, suspension, frames=3):
    """Return a frame with a braking ego, a cyclist and a car in turns to the left."""
    actors = [
        ScriptedActor(x_m=10.0, y_m=y, kind=kind, motion=[Arc("arc", speed_mps=6.0, radius_m=12.0)])
        for y, kind in ((5.0, "bicycle"), (15.0, "car"))
    ]
    ego = ScriptedEgo(motion=[Straight("straight", speed_mps=15.0, acceleration_mps2=-4.0)])
    source = ScriptedSource(ScriptedTraffic(ego=ego, actor=actors, suspension=suspension), Path(), 100.0)
    source.reset(seed=1)
    return [source.step() for _ in range(frames)][-1]


def test_world_frames_hold_the_attitudes():
    frame = scripted_frame(suspension=True)
    turn = 6.0**2 / 12.0
    assert np.degrees(frame.ego.attitude) == pytest.approx([2.0 * 4.0 / GRAVITY, 0.0], abs=1e-9)
    roll_deg = np.degrees(frame.actors.attitude[:, 1])
    assert roll_deg == pytest.approx([-math.degrees(math.atan(turn / GRAVITY)), 5.0 * turn / GRAVITY], rel=1e-6)


def test_suspension_can_be_switched_off():
    frame = scripted_frame(suspension=False)
    assert not frame.ego.attitude.any()
    assert not frame.actors.attitude.any()

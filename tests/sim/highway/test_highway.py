"""highway-env: coordinate frame, egos, commands and errors."""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.paths import without_checkouts
from support.traffic import frames, play

from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.highway.highway_source import HighwaySource
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError

RAW = PhysicalConfig(smoothing_s=0.0, lookahead_s=0.0)
FEW = {"config": {"vehicles_count": 15}}
CONTINUOUS = {"vehicles_count": 0, "action": {"type": "ContinuousAction"}}


@pytest.fixture
def highway():
    made = []

    def make(env, range_m=200.0, **keys):
        made.append(HighwaySource(HighwayTraffic(env=env, **keys), Path(), range_m))
        return made[-1]

    yield make
    for source in made:
        source.close()


def error_message(source, error=TrafficInputError):
    with pytest.raises(error) as caught:
        frames(source, 3, seed=4)
    assert "\n" not in str(caught.value)
    return str(caught.value)


# ---- the mirrored frame


def test_the_roundabout_is_driven_on_the_right(highway):
    seen = frames(highway("roundabout-v0", physical=RAW), 60, seed=4)
    ego = seen[0].ego
    # drawn y-down, the ego comes from the bottom on lane x = +2: northbound, right of the centre line
    assert ego.pose_world == pytest.approx([2.0, -45.0, np.pi / 2], abs=1e-6)
    circling = 0
    for actors in (frame.actors for frame in seen):
        (x, y), (v_x, v_y) = actors.pose_world[:, :2].T, actors.velocity_world.T
        in_circle = np.hypot(x, y) < 25.0
        circling += in_circle.sum()
        assert (x * v_y - y * v_x)[in_circle].min(initial=1.0) > 0.0, (
            "right-hand traffic should circle counter-clockwise"
        )
    assert circling > 20


def test_lanes_count_to_the_right(highway):
    source = highway("highway-v0", config={"vehicles_count": 5, "lanes_count": 3, "initial_lane_id": 2})
    (frame,) = frames(source, 1, seed=4)
    assert frame.ego.pose_world[1:] == pytest.approx([-8.0, 0.0])  # lane 2, lanes of 4 m, the first at y = 0
    assert set(np.round(frame.actors.pose_world[:, 1], 6)) <= {0.0, -4.0, -8.0}


def test_velocity_is_the_derivative_of_the_poses(highway):
    """highway-env's `.velocity` points along the heading, but a bicycle model slips in a bend."""
    seen = frames(highway("roundabout-v0"), 60, seed=4)
    slipped = 0
    for before, after in pairwise(seen):
        moved = (after.ego.pose_world - before.ego.pose_world)[:2] / 0.08
        assert moved == pytest.approx((before.ego.velocity_world + after.ego.velocity_world) / 2, abs=0.15)
        yaw = after.ego.pose_world[2]
        slipped += abs(moved[1] * np.cos(yaw) - moved[0] * np.sin(yaw)) > 0.3
    assert slipped > 5


def test_motions_are_smoothed_and_close_to_the_simulator_s(highway):
    """Fails if smoothing is missing, lags, or displaces by more than half a lane."""
    hardly = PhysicalConfig(smoothing_s=0.0, lookahead_s=0.08)
    raw, smooth = (frames(highway("highway-v0", **FEW, **keys), 60, seed=4) for keys in ({"physical": hardly}, {}))
    off = [np.hypot(*(a.ego.pose_world - b.ego.pose_world)[:2]) for a, b in zip(raw, smooth, strict=True)]
    assert 0.0 < max(off) < 0.5
    hardest = [max(np.hypot(*frame.actors.acceleration_world.T).max() for frame in seen) for seen in (raw, smooth)]
    assert hardest[1] < 0.7 * hardest[0]


def test_a_far_start_moves_the_origin(highway):
    source = highway("highway-v0", config={"vehicles_count": 1, "ego_spacing": 80}, physical=RAW)
    (frame,) = frames(source, 1, seed=4)
    assert source.origin.tolist() == [10_000.0, 0.0]
    assert frame.ego.pose_world[0] == pytest.approx(7_188 - 10_000, abs=1_000)  # 4 x 80 x 37 m x exp(-0.5)


def test_obstacles_are_mirrored_and_landmarks_are_ignored(highway):
    # merge-v0 puts one 2 m by 2 m obstacle at the end of the merging lane, right of the road: below it on the screen
    obstacles = highway("merge-v0").reset(0)
    assert len(obstacles) == 1
    low, high = obstacles.vertices_world.min(axis=0), obstacles.vertices_world.max(axis=0)
    assert high - low == pytest.approx([2.0, 2.0])
    assert high[1] < -4.0
    assert len(highway("parking-v0").reset(0)) == 4  # walls, without the goal


# ---- egos


def test_an_idm_ego_survives_longer_than_a_passive_one_in_dense_traffic(highway):
    dense = {"vehicles_count": 12, "vehicles_density": 2.5, "lanes_count": 2}
    passive = highway("highway-v0", config=dense, ego="fixed", action=3)  # FASTER
    passive.reset(1)
    with pytest.raises(TrafficEndedError, match=r"the ego crashed at \d+\.\d\d s"):
        play(passive, 125)
    assert len(frames(highway("highway-v0", config=dense), 125, seed=1)) == 125


def test_the_idm_ego_follows_its_route_beyond_the_episode(highway):
    # the episode of roundabout-v0 lasts 11 s; its ego is bound for the northern exit
    seen = frames(highway("roundabout-v0"), 200, seed=4)
    assert seen[-1].ego.pose_world[0] == pytest.approx(2.0, abs=0.5)
    assert seen[-1].ego.pose_world[1] > 40.0


def test_the_fixed_action_is_repeated(highway):
    # IDLE keeps 25 m/s, FASTER ends at the highest target speed, SLOWER at the lowest
    for action, speed in {1: 25.0, 3: 30.0, 4: 20.0}.items():
        alone = highway("highway-v0", config={"vehicles_count": 0}, ego="fixed", action=action)
        assert np.hypot(*frames(alone, 60, seed=4)[-1].ego.velocity_world) == pytest.approx(speed, abs=0.1)


def test_a_continuous_action_is_repeated(highway):
    alone = highway("highway-v0", config=CONTINUOUS, ego="fixed", action=[0.2, 0.0])  # of 5 m/s^2
    ego = frames(alone, 26, seed=4)[-1].ego
    assert ego.velocity_world == pytest.approx([25.0 + 0.2 * 5.0 * 2.0, 0.0], abs=0.05)
    assert ego.acceleration_world == pytest.approx([1.0, 0.0], abs=0.01)
    steered = highway("highway-v0", config=CONTINUOUS, ego="fixed", action=[0.0, 0.05])
    assert frames(steered, 10, seed=4)[-1].ego.yaw_rate < -0.1  # to the right, as drawn y-down


def test_the_ego_of_a_car_park_stands_and_can_be_controlled(highway):
    parked = frames(highway("parking-parked-v0"), 30, seed=4)
    assert len(parked[0].actors) == 10
    assert all((frame.ego.pose_world == parked[0].ego.pose_world).all() for frame in parked)
    backwards = frames(highway("parking-parked-v0", ego="fixed", action=[-0.4, 0.0]), 26, seed=4)[-1].ego
    course = np.arctan2(*backwards.velocity_world[::-1])
    assert np.hypot(*backwards.velocity_world) == pytest.approx(0.4 * 5.0 * 2.0, abs=0.05)
    assert abs(course - backwards.pose_world[2]) == pytest.approx(np.pi)


def test_an_ego_with_slipping_tyres_keeps_its_lanes(highway):
    """lane-keeping-v0's vehicle slides; two straight lanes lead to y = 5 m sin(2 pi x / 100 m), drawn y-down."""
    seen = frames(highway("lane-keeping-v0", physical=RAW), 200, seed=4)
    x, y = np.array([frame.ego.pose_world[:2] for frame in seen[100:]]).T
    assert x[-1] > 200.0
    assert np.abs(y + 5.0 * np.sin(2 * np.pi * x / 100.0)).max() < 2.0
    assert not any(len(frame.actors) for frame in seen)


# ---- commands


def test_a_command_is_effective_until_the_next_one(highway):
    alone = highway("highway-v0", config={"vehicles_count": 0}, ego="controlled")
    alone.reset(4)
    speeds = []
    for action in (None, 4, 1):  # SLOWER sets the next lower of 20, 25 and 30 m/s, IDLE keeps what is set
        if action is not None:
            alone.apply(EgoCommand(action=action))
        speeds.append([np.hypot(*alone.step().ego.velocity_world) for _ in range(50)])
    assert speeds[0] == pytest.approx([25.0] * 50, abs=1e-6)
    assert speeds[1][-1] == pytest.approx(20.0, abs=0.1)
    assert speeds[2] == pytest.approx([20.0] * 50, abs=0.1)


def test_a_continuous_command_is_effective_within_one_frame(highway):
    alone = highway("highway-v0", config=CONTINUOUS, ego="controlled", physical=RAW)
    x = [frame.ego.pose_world[0] for frame in frames(alone, 2, seed=4)]
    alone.apply(EgoCommand(action=np.array([1.0, 0.0])))
    x += [alone.step().ego.pose_world[0]]
    # two steps of 40 ms: the first still at 25 m/s, the second 5 m/s^2 x 40 ms faster
    assert np.diff(x) == pytest.approx([2.0, 2.0 + 0.2 * 0.04], abs=1e-9)


def test_further_agents_are_independent_of_the_ego_s_commands(highway):
    source = highway("intersection-multi-agent-v0", ego="controlled")
    idle = frames(source, 12, seed=1)[-1]
    source.reset(1)
    source.apply(EgoCommand(action=0))  # SLOWER
    slower = [source.step() for _ in range(12)][-1]
    np.testing.assert_array_equal(idle.actors.id, slower.actors.id)
    # the other agent entered last, and is too far from the ego to react
    assert idle.actors.pose_world[-1] == pytest.approx(slower.actors.pose_world[-1], abs=1e-9)
    assert np.hypot(*(idle.ego.pose_world - slower.ego.pose_world)[:2]) > 0.3


@pytest.mark.parametrize(
    ("env", "action", "space"),
    [
        ("highway-v0", 5, "Discrete(5)"),
        ("highway-v0", [0.0, 0.0], "Discrete(5)"),
        ("intersection-multi-agent-v0", (1, 1), "Discrete(3)"),
        ("racetrack-v0", 1, "Box(-1.0, 1.0, (1,), float32)"),
        ("racetrack-v0", [0.1, 0.1], "Box(-1.0, 1.0, (1,), float32)"),
        ("racetrack-v0", [1.1], "Box(-1.0, 1.0, (1,), float32)"),
        ("racetrack-v0", [float("nan")], "Box(-1.0, 1.0, (1,), float32)"),
        ("racetrack-v0", ["left"], "Box(-1.0, 1.0, (1,), float32)"),
    ],
)
def test_an_action_outside_of_the_space_is_rejected_and_the_last_one_stays(highway, env, action, space):
    source = highway(env, ego="controlled")
    source.reset(4)
    with pytest.raises(TrafficInputError) as caught:
        source.apply(EgoCommand(action=action))
    assert f"is not among {env}'s actions, {space}; choose one of these" in str(caught.value)
    assert "\n" not in str(caught.value)
    play(source, 3)


@pytest.mark.parametrize("command", [EgoCommand(speed_mps=5.0), EgoCommand(action=1, lane=0), EgoCommand()])
def test_commands_for_other_simulators_are_rejected(highway, command):
    source = highway("highway-v0", ego="controlled")
    source.reset(4)
    with pytest.raises(TrafficInputError, match="takes an action, neither speed_mps nor lane"):
        source.apply(command)


def test_only_a_controlled_ego_accepts_commands(highway):
    source = highway("highway-v0")
    source.reset(4)
    with pytest.raises(TrafficInputError, match='the ego is "idm"; commands need ego = "controlled"'):
        source.apply(EgoCommand(action=1))
    with pytest.raises(SimulatorFailedError, match="call reset before apply"):
        highway("highway-v0", ego="controlled").apply(EgoCommand(action=1))


def test_a_controlled_ego_has_no_look_ahead():
    assert HighwayTraffic(ego="controlled").smoothing.lookahead_s == 0.0
    with pytest.raises(ValueError, match="lookahead_s must be 0"):
        HighwayTraffic(ego="controlled", physical=PhysicalConfig(0.32, lookahead_s=0.32))


# ---- road users


def test_numbers_of_departed_vehicles_are_not_reused(highway):
    seen = frames(highway("intersection-v0"), 115, seed=1)
    numbers = [set(frame.actors.id.tolist()) for frame in seen]
    gone = set()
    for before, after in pairwise(numbers):
        gone |= before - after
        assert not gone & after
    assert gone


def test_an_intersection_does_not_change_the_driver_model_permanently(highway):
    from highway_env.vehicle.behavior import IDMVehicle

    before = IDMVehicle.DISTANCE_WANTED, IDMVehicle.COMFORT_ACC_MAX, IDMVehicle.COMFORT_ACC_MIN
    source = highway("intersection-v0")
    source.reset(0)
    assert before[0] != IDMVehicle.DISTANCE_WANTED, (
        "the intersection no longer changes class attributes; the restoration is obsolete"
    )
    source.close()
    assert before == (IDMVehicle.DISTANCE_WANTED, IDMVehicle.COMFORT_ACC_MAX, IDMVehicle.COMFORT_ACC_MIN)


# ---- bad input


def test_an_unknown_environment_is_reported_with_similar_names(highway):
    message = error_message(highway("higway-v0"))
    assert 'env = "higway-v0" is unknown' in message
    assert "highway-v0" in message.partition("did you mean")[2]
    assert "roundabout-v0" in error_message(highway("CartPole-v1"))


def test_an_unknown_key_of_the_environment_is_reported(highway):
    message = error_message(highway("highway-v0", config={"vehicle_count": 3}))
    assert "config.vehicle_count is unknown to highway-v0; did you mean vehicles_count" in message


@pytest.mark.parametrize("config", [{"vehicles_count": "many"}, {"other_vehicles_type": "no.such.Driver"}])
def test_an_invalid_value_of_the_environment_is_reported(highway, config):
    assert error_message(highway("highway-v0", config=config))


def test_a_driver_of_a_former_module_names_the_new_one(highway, monkeypatch):
    monkeypatch.setattr(sys, "path", without_checkouts(sys.path))
    message = error_message(highway("highway-v0", config={"other_vehicles_type": "sim.highway.motorist.Motorist"}))
    assert message.startswith("config.other_vehicles_type: ModuleNotFoundError: No module named 'sim")
    assert "; luxloop's module is luxloop.sim" in message


def test_a_fixed_action_must_exist(highway):
    assert "action = 9 is not among highway-v0's actions" in error_message(highway("highway-v0", ego="fixed", action=9))
    assert "Box(-1.0, 1.0, (2,), float32)" in error_message(highway("parking-v0", ego="fixed"))


def test_an_exception_during_the_run_is_a_simulator_failure(highway):
    source = highway("highway-v0", config={"collision_reward": "much"})  # multiplied after each step
    assert "highway-v0: TypeError: " in error_message(source, SimulatorFailedError)


def test_the_rate_is_fixed_by_the_rig():
    with pytest.raises(ValueError, match="remove it"):
        HighwayTraffic(config={"policy_frequency": 5})


def test_step_before_reset_raises(highway):
    with pytest.raises(SimulatorFailedError, match="call reset before step"):
        highway("highway-v0").step()

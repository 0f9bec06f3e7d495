"""highway-env: its frame, its egos, its faults."""

from itertools import pairwise
from pathlib import Path

import gymnasium
import highway_env  # noqa: F401  registers its environments
import numpy as np
import pytest
from highway_env.vehicle.behavior import IDMVehicle
from support.traffic import frames, play

from sim.highway import HighwaySource, HighwayTraffic
from sim.source import SimulatorFailedError, TrafficEndedError, TrafficInputError

ALL_IDS = sorted(name for name, spec in gymnasium.registry.items() if str(spec.entry_point).startswith("highway_env."))


@pytest.fixture
def highway():
    made = []

    def make(env, range_m=200.0, **keys):
        made.append(HighwaySource(HighwayTraffic(env=env, **keys), Path(), range_m))
        return made[-1]

    yield make
    for source in made:
        source.close()


def complaint(source, error=TrafficInputError):
    with pytest.raises(error) as caught:
        frames(source, 3, seed=4)
    assert "\n" not in str(caught.value)
    return str(caught.value)


# ---- the mirrored frame


def test_the_roundabout_is_driven_on_the_right(highway):
    seen = frames(highway("roundabout-v0"), 60, seed=4)
    ego = seen[0].ego
    # drawn y-down, the ego comes from the bottom on lane x = +2: northbound, right of the centre line
    assert ego.pose_world == pytest.approx([2.0, -45.0, np.pi / 2], abs=1e-6)
    circling = 0
    for actors in (frame.actors for frame in seen):
        (x, y), (v_x, v_y) = actors.pose_world[:, :2].T, actors.velocity_world.T
        in_circle = np.hypot(x, y) < 25.0
        circling += in_circle.sum()
        assert (x * v_y - y * v_x)[in_circle].min(initial=1.0) > 0.0, "right-hand traffic circles counter-clockwise"
    assert circling > 20


def test_lanes_count_to_the_right(highway):
    source = highway("highway-v0", config={"vehicles_count": 5, "lanes_count": 3, "initial_lane_id": 2})
    (frame,) = frames(source, 1, seed=4)
    assert frame.ego.pose_world[1:] == pytest.approx([-8.0, 0.0])  # lane 2, lanes of 4 m, the first at y = 0
    assert set(np.round(frame.actors.pose_world[:, 1], 6)) <= {0.0, -4.0, -8.0}


def test_velocity_is_that_of_the_poses_not_highway_env_s_own(highway):
    """Its own `.velocity` points along the heading; a bicycle model slips in a bend."""
    seen = frames(highway("roundabout-v0"), 60, seed=4)
    slipped = 0
    for before, after in pairwise(seen):
        moved = (after.ego.pose_world - before.ego.pose_world)[:2] / 0.08
        assert moved == pytest.approx(after.ego.velocity_world, abs=1e-9)
        yaw = after.ego.pose_world[2]
        slipped += abs(moved[1] * np.cos(yaw) - moved[0] * np.sin(yaw)) > 0.3
    assert slipped > 5


def test_obstacles_stand_mirrored_and_landmarks_do_not(highway):
    # merge-v0 puts one 2 m by 2 m obstacle at the end of the merging lane, right of the road: below it on the screen
    obstacles = highway("merge-v0").reset(0)
    assert len(obstacles) == 1
    low, high = obstacles.vertices_world.min(axis=0), obstacles.vertices_world.max(axis=0)
    assert high - low == pytest.approx([2.0, 2.0])
    assert high[1] < -4.0
    assert len(highway("parking-v0").reset(0)) == 4  # its walls, but not its goal


# ---- egos


@pytest.mark.parametrize("env", [name for name in ALL_IDS if name != "lane-keeping-v0"])
def test_every_environment_runs_under_idm(highway, env):
    seen = frames(highway(env), 6, seed=4)
    assert np.isfinite(seen[-1].ego.pose_world).all()


def test_an_idm_ego_outlives_a_passive_one_in_dense_traffic(highway):
    dense = {"vehicles_count": 12, "vehicles_density": 2.5, "lanes_count": 2}
    passive = highway("highway-v0", config=dense, ego="fixed", action=3)  # FASTER
    passive.reset(1)
    with pytest.raises(TrafficEndedError, match=r"the ego crashed at \d+\.\d\d s"):
        play(passive, 125)
    assert len(frames(highway("highway-v0", config=dense), 125, seed=1)) == 125


def test_the_idm_ego_follows_its_route_and_outlasts_the_episode(highway):
    # the episode of roundabout-v0 lasts 11 s; its ego is bound for the northern exit
    seen = frames(highway("roundabout-v0"), 200, seed=4)
    assert seen[-1].ego.pose_world[0] == pytest.approx(2.0, abs=0.5)
    assert seen[-1].ego.pose_world[1] > 40.0


def test_the_fixed_action_is_repeated(highway):
    # IDLE keeps 25 m/s, FASTER ends at the highest target speed, SLOWER at the lowest
    for action, speed in {1: 25.0, 3: 30.0, 4: 20.0}.items():
        alone = highway("highway-v0", config={"vehicles_count": 0}, ego="fixed", action=action)
        assert np.hypot(*frames(alone, 60, seed=4)[-1].ego.velocity_world) == pytest.approx(speed, abs=0.1)


def test_vehicles_that_leave_do_not_pass_their_number_on(highway):
    seen = frames(highway("intersection-v0"), 115, seed=1)
    numbers = [set(frame.actors.id.tolist()) for frame in seen]
    gone = set()
    for before, after in pairwise(numbers):
        gone |= before - after
        assert not gone & after
    assert gone


def test_an_intersection_leaves_the_driver_model_as_it_was(highway):
    before = IDMVehicle.DISTANCE_WANTED, IDMVehicle.COMFORT_ACC_MAX, IDMVehicle.COMFORT_ACC_MIN
    source = highway("intersection-v0")
    source.reset(0)
    assert before[0] != IDMVehicle.DISTANCE_WANTED, "the intersection no longer tunes; the guard can go"
    source.close()
    assert before == (IDMVehicle.DISTANCE_WANTED, IDMVehicle.COMFORT_ACC_MAX, IDMVehicle.COMFORT_ACC_MIN)


# ---- bad input


def test_an_unknown_environment_is_named_with_close_ones(highway):
    said = complaint(highway("higway-v0"))
    assert 'env = "higway-v0" is unknown' in said
    assert "highway-v0" in said.partition("did you mean")[2]
    assert "roundabout-v0" in complaint(highway("CartPole-v1"))


def test_an_unknown_key_of_the_environment_is_named(highway):
    said = complaint(highway("highway-v0", config={"vehicle_count": 3}))
    assert "config.vehicle_count is unknown to highway-v0; did you mean vehicles_count" in said


@pytest.mark.parametrize("config", [{"vehicles_count": "many"}, {"other_vehicles_type": "no.such.Driver"}])
def test_a_value_that_the_environment_cannot_take(highway, config):
    assert complaint(highway("highway-v0", config=config))


def test_a_fixed_action_must_exist(highway):
    assert "action = 9 is not among highway-v0's actions" in complaint(highway("highway-v0", ego="fixed", action=9))
    assert 'use ego = "idm"' in complaint(highway("parking-v0", ego="fixed"))


def test_what_the_environment_cannot_do_is_the_simulator_s_failure(highway):
    assert "lane-keeping-v0: AttributeError" in complaint(highway("lane-keeping-v0"), SimulatorFailedError)


def test_the_rate_belongs_to_the_rig():
    with pytest.raises(ValueError, match="leave it out"):
        HighwayTraffic(config={"policy_frequency": 5})


def test_step_before_reset_is_told(highway):
    with pytest.raises(SimulatorFailedError, match="reset comes before step"):
        highway("highway-v0").step()

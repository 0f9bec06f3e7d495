"""Motorist: limits of its motion, and progress through traffic."""

from contextlib import closing
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.few import few
from support.traffic import frames

from luxloop.scenarios.grading.truth_events.bodies import Bodies, MotionHistory
from luxloop.scenarios.grading.truth_events.truth_event import exceedance
from luxloop.sim.highway.environment import environments
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.highway.highway_source import HighwaySource

MOTORIST = {"other_vehicles_type": "luxloop.sim.highway.motorist.Motorist"}
DENSE = {"lanes_count": 4, "vehicles_count": 20, "vehicles_density": 2.0}
RUNS = {"highway-v0": DENSE, "roundabout-v1": {}, "merge-v0": {}, "u-turn-v0": {}, "intersection-v0": {}}


@pytest.fixture
def highway():
    made = []

    def make(env, **config):
        made.append(HighwaySource(HighwayTraffic(env=env, config=config), Path(), 1000.0))
        return made[-1]

    yield make
    for source in made:
        source.close()


@cache
def driven(env):
    """Return 200 frames of an environment of `RUNS`, simulated once for all tests."""
    with closing(HighwaySource(HighwayTraffic(env=env, config={**MOTORIST, **RUNS[env]}), Path(), 1000.0)) as source:
        return frames(source, 200, seed=2)


def column(seen, name):
    """Return a column of the ego and the actors, concatenated over all frames."""
    return np.concatenate([np.vstack([getattr(frame.ego, name)[None], getattr(frame.actors, name)]) for frame in seen])


def lateral_acceleration(seen):
    yaw, acceleration = column(seen, "pose_world")[:, 2], column(seen, "acceleration_world")
    return np.abs(acceleration[:, 1] * np.cos(yaw) - acceleration[:, 0] * np.sin(yaw))


@pytest.mark.parametrize("env", few(RUNS, *[*RUNS][:2]))
def test_motions_are_feasible_for_cars(env):
    seen = driven(env)
    yaw, velocity = column(seen, "pose_world")[:, 2], column(seen, "velocity_world")
    assert np.hypot(*column(seen, "acceleration_world").T).max() <= 10.0
    assert lateral_acceleration(seen).max() <= 6.0
    assert (velocity[:, 0] * np.cos(yaw) + velocity[:, 1] * np.sin(yaw)).min() > -0.01, "a vehicle reverses"
    assert np.abs(column(seen, "deviation")).max() < 0.2, "the truth layer should hardly change the motion"
    for before, after in pairwise(seen):
        assert abs(after.ego.yaw_rate) <= 1.2
        assert np.abs(after.actors.yaw_rate).max(initial=0.0) <= 1.2
        _, old, new = np.intersect1d(before.actors.id, after.actors.id, return_indices=True)
        jerk = (after.actors.acceleration_world[new] - before.actors.acceleration_world[old]) / 0.08
        assert np.hypot(*jerk.T).max(initial=0.0) <= 60.0


@pytest.mark.parametrize("env", few(environments(), "intersection-v0", "merge-v0"))
def test_every_environment_stays_within_the_limits_of_truth_events(highway, env):
    source, history, peaks = highway(env, **MOTORIST), MotionHistory(), np.zeros(3)
    for frame in frames(source, 35, seed=1):
        peaks = np.maximum(peaks, history.add(Bodies.of(frame)).quantities.max(axis=0))
    assert (exceedance(peaks[None]) <= 1.0).all(), f"m/s^2, m/s^3, rad/s: {peaks}"


def test_highway_env_has_the_number_of_environments_that_the_page_names():
    assert len(environments()) == 31


@pytest.mark.parametrize(
    ("env", "count"),
    few([("intersection-multi-agent-v0", 105), ("intersection-v0", 249)], "intersection-multi-agent-v0"),
)
def test_a_driver_with_right_of_way_stops_before_a_vehicle_that_stands_in_the_way(highway, env, count):
    """It used to drive on at 7 to 8 m/s: at 6.7 s and 19.4 s it hit a vehicle that had stopped on the intersection to
    give way. After a collision highway-env pushes the bodies apart, with 13 to 14.5 m/s^2."""
    source = highway(env, **MOTORIST)
    seen = frames(source, count, seed=1)
    assert not any(vehicle.crashed for vehicle in source._env.road.vehicles)
    assert np.hypot(*column(seen, "acceleration_world").T).max() <= 10.0
    assert any(np.hypot(*frame.actors.velocity_world.T).min(initial=9.0) < 0.01 for frame in seen), "none had to stop"


def test_motions_of_highway_env_s_drivers_are_infeasible(highway):
    """If this fails, the motorist is no longer needed."""
    assert lateral_acceleration(frames(highway("roundabout-v1"), 60, seed=2)).max() > 15.0


@pytest.mark.parametrize("seed", few(range(1, 6), 2))
def test_the_ego_gets_through_the_roundabout(highway, seed):
    """Fails if motorists do not give way: with other vehicles at half speed, the gaps are too short for the ego."""
    seen = driven("roundabout-v1") if seed == 2 else frames(highway("roundabout-v1", **MOTORIST), 180, seed=seed)
    assert seen[179].ego.pose_world[1] > 15.0


def test_a_lane_change_has_a_realistic_duration_and_ends_in_the_lane():
    seen = driven("highway-v0")
    y = np.array([frame.ego.pose_world[1] for frame in seen])
    lane = np.round(y / -4.0)
    (change,) = np.flatnonzero(np.diff(lane))[:1]
    under_way = np.abs(y[max(change - 60, 0) : change + 60] + 4.0 * lane[change]) % 4.0
    seconds = 0.08 * ((under_way > 0.2) & (under_way < 3.8)).sum()
    assert 1.5 < seconds < 5.0
    assert np.abs(y[-10:] + 4.0 * lane[-10:]).max() < 0.3

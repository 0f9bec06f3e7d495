"""All environments of highway-env: some hundred frames of each, and control of its ego."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.few import few
from support.traffic import documented_environments, frames, registered_environments

from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.highway.highway_source import HighwaySource
from luxloop.sim.kinematics import wrap_angle
from luxloop.sim.roster import EGO_ID
from luxloop.sim.source import EgoCommand, TrafficEndedError

ALL_IDS = documented_environments()
QUICK = ("highway-fast-v0", "intersection-v1", "lane-keeping-v0", "parking-v0", "roundabout-v0")
"""Environments of `make test`; `make slow` runs the others."""
QUICKEST = ("intersection-v1", "lane-keeping-v0", "roundabout-v0")
"""Environments that `make test` runs for longer: a crossing, slipping tyres and bends."""
FRAMES, MANY = 80, 200
RANGE_M = 150.0
SEED = {"intersection-v2": 1}
"""Seeds with which the ego arrives; 3 for all others. IDM ignores crossing traffic."""
LONG = (
    *("exit-v0", "highway-fast-v0", "intersection-multi-agent-v0", "intersection-v0", "lane-keeping-v0", "merge-v0"),
    *("parking-v0", "racetrack-v0", "roundabout-v0", "two-way-v0", "u-turn-v0"),
)
"""An environment of each road: it runs for longer, until vehicles have left and others have come."""
SLOWER = {5: 4, 3: 0}
"""Index by the number of discrete actions."""
FULL = {
    "intersection-v1": [-1.0, 0.0],  # brake
    "lane-keeping-v0": [0.5],  # steer
    "parking-ActionRepeat-v0": [-1.0, 0.5],  # reverse in a bend
    "parking-parked-v0": [-1.0, 0.5],
    "parking-v0": [-1.0, 0.5],
}
"""Actions of continuous environments; on all racetracks the action is steering."""


@pytest.fixture
def highway():
    made = []

    def make(env, **keys):
        made.append(HighwaySource(HighwayTraffic(env=env, **keys), Path(), RANGE_M))
        return made[-1]

    yield make
    for source in made:
        source.close()


def action(env):
    if env.startswith("racetrack"):
        return [0.3]
    if env in FULL:
        return FULL[env]
    return SLOWER[3 if env.startswith("intersection") else 5]


def test_the_list_of_environments_is_complete():
    assert registered_environments() == ALL_IDS, "the registered environments have changed; update docs/traffic.md"
    assert len(ALL_IDS) == 31, "the number of environments has changed; update the tables above"
    assert set(LONG) <= set(ALL_IDS)
    assert {env.partition("-")[0] for env in LONG} == {env.partition("-")[0] for env in ALL_IDS}


@pytest.mark.parametrize(
    ("env", "count"),
    [
        *few(((env, MANY if env in LONG else FRAMES) for env in ALL_IDS), *QUICKEST),
        *(pytest.param(env, MANY, marks=pytest.mark.slow) for env in ALL_IDS if env not in LONG),
    ],
)
def test_every_environment_runs_under_idm(highway, env, count):
    source = highway(env)
    seen = frames(source, count, seed=SEED.get(env, 3))
    assert [frame.index for frame in seen] == list(range(count))
    assert source.origin == pytest.approx([0.0, 0.0], abs=0)
    for frame in seen:
        check_frame(frame)
    for before, after in pairwise(seen):
        check_motion(before, after, source.dt)
    check_ids(seen)
    distance = np.hypot(*(seen[-1].ego.pose_world - seen[0].ego.pose_world)[:2])
    if env.startswith("parking"):
        assert distance == 0.0
        assert not seen[-1].ego.velocity_world.any()
    else:
        assert distance > 10.0


def check_frame(frame):
    actors, ego = frame.actors, frame.ego
    columns = (actors.pose_world, actors.velocity_world, actors.acceleration_world, actors.yaw_rate, actors.size)
    for column in (*columns, ego.pose_world, ego.velocity_world, ego.acceleration_world, ego.yaw_rate):
        assert np.isfinite(column).all()
    assert EGO_ID not in actors.id
    assert (np.diff(actors.id) > 0).all()
    assert (np.hypot(*(actors.pose_world - ego.pose_world)[:, :2].T) <= RANGE_M).all()


def check_motion(before, after, dt):
    """Velocities are the difference quotients of the poses, and yaw rates are limited."""
    _, old, new = np.intersect1d(before.actors.id, after.actors.id, return_indices=True)
    poses, velocities = zip(with_ego(before, old), with_ego(after, new), strict=True)
    moved = poses[1] - poses[0]
    assert (np.hypot(*(moved[:, :2] / dt - (velocities[0] + velocities[1]) / 2).T) <= 0.15).all()
    assert (np.abs(wrap_angle(moved[:, 2])) <= 3.0 * dt).all()


def with_ego(frame, rows):
    """Return poses and velocities of the ego and of some actors."""
    ego, actors = frame.ego, frame.actors
    return (
        np.vstack([ego.pose_world, actors.pose_world[rows]]),
        np.vstack([ego.velocity_world, actors.velocity_world[rows]]),
    )


def check_ids(seen):
    """Each number belongs to one road user, and each name to one number."""
    owner = {}
    for frame in seen:
        for number, name, *size in zip(frame.actors.id, frame.actors.name, *frame.actors.size.T, strict=True):
            assert owner.setdefault(int(number), (str(name), *size)) == (str(name), *size)
    assert len({name for name, *_ in owner.values()}) == len(owner)


@pytest.mark.parametrize("env", few(ALL_IDS, *QUICK))
def test_every_ego_executes_its_action(highway, env):
    """Fails if an action has no effect, or reaches another agent than the ego."""
    source, command = highway(env, ego="controlled"), action(env)
    idle = frames(source, 15, seed=3)
    source.reset(3)
    before = [source.step() for _ in range(3)]
    source.apply(EgoCommand(action=command))
    obeyed = before + [source.step() for _ in range(12)]
    for frame, other in zip(idle[:3], before, strict=True):
        np.testing.assert_array_equal(frame.ego.pose_world, other.ego.pose_world)
    assert np.hypot(*(obeyed[-1].ego.pose_world - idle[-1].ego.pose_world)[:2]) > 0.3


def test_an_ego_that_crashes_ends_the_run_after_the_last_whole_frame(highway):
    source = highway("roundabout-generic-v0")
    source.reset(1)
    seen = [source.step() for _ in range(82)]  # at 0 to 6.48 s, independent of the look-ahead
    with pytest.raises(TrafficEndedError, match=r"the ego crashed at 6\.56 s; try another seed"):
        source.step()
    for frame in seen:
        check_frame(frame)
    with pytest.raises(TrafficEndedError, match="crashed"):
        source.step()  # the error repeats

"""Contract of every traffic source, tested on scenarios of all kinds with their real simulators."""

from contextlib import closing
from dataclasses import fields
from itertools import pairwise

import numpy as np
import pytest
from support.few import few
from support.paths import CATALOG, EXAMPLES

from luxloop.scenarios.files.scenario import Scenario
from luxloop.sim.highway.highway_source import HighwaySource
from luxloop.sim.kinematics import wrap_angle
from luxloop.sim.openscenario.openscenario_source import OpenScenarioSource
from luxloop.sim.replay.replay_source import ReplaySource
from luxloop.sim.roster import EGO_ID
from luxloop.sim.scripted.scripted_source import ScriptedSource
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.world import Kind

SOURCES = {
    "sumo": SumoSource,
    "highway-env": HighwaySource,
    "scripted": ScriptedSource,
    "replay": ReplaySource,
    "openscenario": OpenScenarioSource,
}
SCENARIOS = [
    "urban/sumo-crossing",
    "highway/sumo-cut-in",
    "highway/highway-v0",
    "urban/roundabout-v0",
    "occlusion/truck-shadow",
    "fitting/ring",
    "urban/replayed-crossing",
    "highway/cruise-on-tracks",
    "cut-in",
]
SLOW = ("highway/sumo-cut-in", "highway/highway-v0")
"""Second scenarios of their simulators, which take the longest: `make slow` runs them."""
RANGE_M = 60.0
FRAMES = 40


class Runs:
    """First frames of a scenario by one source: `first` with one seed, `other` with another, `again` with the first."""

    def __init__(self, name):
        folder = CATALOG if "/" in name else EXAMPLES
        scenario = Scenario.load(folder / f"{name}.toml")
        with closing(SOURCES[scenario.traffic.kind](scenario.traffic, scenario.folder, RANGE_M)) as source:
            self.dt = source.dt
            self.first, self.other, self.again = (self.record(source, seed) for seed in (5, 6, 5))

    @staticmethod
    def record(source, seed):
        return source.reset(seed), [source.step() for _ in range(FRAMES)]


@pytest.fixture(scope="module", params=few(SCENARIOS, *(name for name in SCENARIOS if name not in SLOW)))
def runs(request):
    return Runs(request.param)


def arrays(record):
    """Return all arrays of a run, in order: obstacles, then egos and actors of all frames."""
    obstacles, frames = record
    parts = [obstacles, *(part for frame in frames for part in (frame.ego, frame.actors))]
    values = [getattr(part, field.name) for part in parts for field in fields(part)]
    assert obstacles.terrain is None  # the sources of this test are flat
    return [np.asarray(value) for value in values if value is not None]


def same(record, other):
    pairs = zip(arrays(record), arrays(other), strict=True)
    return all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in pairs)


def consecutive(frames):
    """Yield rows of actors in two consecutive frames: (before, its rows, after, its rows)."""
    for before, after in pairwise(frames):
        _, old, new = np.intersect1d(before.actors.id, after.actors.id, return_indices=True)
        yield before.actors, old, after.actors, new


def test_the_same_seed_gives_bit_identical_frames(runs):
    assert same(runs.first, runs.again), "state survives a reset, in the source or in the process"


def test_another_seed_gives_different_frames(runs):
    assert not same(runs.first, runs.other)


def test_frames_are_counted_at_the_rig_s_rate(runs):
    assert runs.dt == 0.08
    assert [frame.index for frame in runs.first[1]] == list(range(FRAMES))
    assert [frame.time for frame in runs.first[1]] == pytest.approx(np.arange(FRAMES) * 0.08, abs=1e-12)


def test_ids_are_sorted_and_never_reused(runs):
    known = {}
    for frame in runs.first[1]:
        actors = frame.actors
        assert (np.diff(actors.id) > 0).all()
        for row in range(len(actors)):
            properties = (str(actors.name[row]), actors.kind[row], *actors.size[row], actors.reflectivity[row])
            assert known.setdefault(int(actors.id[row]), properties) == properties
    names = [properties[0] for properties in known.values()]
    assert len(set(names)) == len(names) > 0


def test_the_ego_is_not_among_the_actors(runs):
    for frame in runs.first[1]:
        assert EGO_ID not in frame.actors.id
        gap = frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]
        assert (np.hypot(*gap.T) > 1.0).all()


def test_actors_are_in_range(runs):
    for frame in runs.first[1]:
        gap = frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]
        assert (np.hypot(*gap.T) <= RANGE_M).all()


def test_values_are_finite_and_valid(runs):
    for array in arrays(runs.first):
        assert array.dtype.kind in "US" or np.isfinite(array).all()
    for frame in runs.first[1]:
        actors, ego = frame.actors, frame.ego
        assert (actors.size > 0).all()
        assert (ego.size > 0).all()
        assert ((actors.reflectivity > 0) & (actors.reflectivity < 1)).all()
        assert {Kind(kind) for kind in actors.kind} <= set(Kind)
        yaw = np.append(actors.pose_world[:, 2], ego.pose_world[2])
        assert ((yaw > -np.pi) & (yaw <= np.pi)).all()


def test_velocity_and_yaw_rate_are_derivatives_of_the_poses(runs):
    for before, old, after, new in consecutive(runs.first[1]):
        moved = (after.pose_world[new] - before.pose_world[old]) / runs.dt
        mean_velocity = (before.velocity_world[old] + after.velocity_world[new]) / 2
        assert np.hypot(*(moved[:, :2] - mean_velocity).T) == pytest.approx(0.0, abs=0.05)
        turned = wrap_angle(moved[:, 2] * runs.dt) / runs.dt
        mean_yaw_rate = (before.yaw_rate[old] + after.yaw_rate[new]) / 2
        assert turned == pytest.approx(mean_yaw_rate, abs=0.02)


def test_speeds_and_slip_angles_are_limited(runs):
    """Detects front bumpers used as centres, angles used as yaws and frames that are not mirrored."""
    for frame in runs.first[1]:
        velocity, yaw = frame.actors.velocity_world, frame.actors.pose_world[:, 2]
        speed = np.hypot(*velocity.T)
        assert (speed < 45.0).all()
        course = np.arctan2(velocity[:, 1], velocity[:, 0])
        slip = np.abs(wrap_angle(course - yaw))[speed > 3.0]
        assert (slip < 0.6).all()  # highway-env's bicycle model slips by up to half its steering

"""Feasible motion in every shipped scenario and on the test nets with bends and merges."""

from contextlib import closing, suppress

import numpy as np
import pytest
from support.few import few
from support.frames import Body, world_frame
from support.motion_limits import LIMITS, excesses, worst_motion
from support.nets import source_on
from support.paths import EXAMPLES
from support.real_data import real_file

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import paths
from luxloop.sim.highway.highway_config import HighwayTraffic
from luxloop.sim.highway.highway_source import HighwaySource
from luxloop.sim.openscenario.openscenario_config import OpenScenarioTraffic
from luxloop.sim.openscenario.openscenario_source import OpenScenarioSource
from luxloop.sim.replay.replay_config import ReplayTraffic
from luxloop.sim.replay.replay_source import ReplaySource
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.source import TrafficEndedError
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

SOURCES = {
    SumoTraffic: SumoSource,
    HighwayTraffic: HighwaySource,
    ScriptedTraffic: ScriptedSource,
    ReplayTraffic: ReplaySource,
    OpenScenarioTraffic: OpenScenarioSource,
}
RANGE_M = 200.0
ON_NETS_S = 60.0


def motion(source, seed, duration_s):
    """Return the worst values of a run, which ends with the scenario or the ego."""
    frames = []
    with closing(source), suppress(TrafficEndedError):
        source.reset(seed)
        while len(frames) < round(duration_s / source.dt):
            frames.append(source.step())
    assert len(frames) > min(50, duration_s / source.dt - 1)
    return worst_motion(frames, source.dt)


# The mean yaw rate of a step is not that of its ends where a pedestrian's rate reaches its limit within the step.
TURNS_AT_ITS_LIMIT = pytest.mark.xfail(reason="0.062 > 0.05 rad/s in one frame, a pedestrian", strict=True)


QUICK = ("bus-stop", "cruise-on-tracks", "replayed-crossing")
"""Scenarios of `make test`, of every simulator but highway-env, whose limits tests/sim/highway checks."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[TURNS_AT_ITS_LIMIT, pytest.mark.slow]) if name == "crosswalk" else case
        for name, case in zip(paths(), few(paths(), *QUICK), strict=True)
    ],
)
def test_motion_in_a_shipped_scenario_is_feasible(name):
    scenario = Scenario.load(paths()[name])
    source = SOURCES[type(scenario.traffic)](scenario.traffic, scenario.folder, RANGE_M)
    assert excesses(motion(source, scenario.seed, scenario.duration_s)) == []


def test_motion_of_a_storyboard_is_feasible():
    scenario = Scenario.load(EXAMPLES / "cut-in.toml")
    source = OpenScenarioSource(scenario.traffic, scenario.folder, RANGE_M)
    assert excesses(motion(source, scenario.seed, scenario.duration_s)) == []


@pytest.mark.parametrize("name", ["cut-in", "slow-lead-vehicle", "straight_500m"])
def test_motion_of_public_storyboards_is_feasible(name):
    path = real_file(f"openscenario/xosc/{name}.xosc")
    source = OpenScenarioSource(OpenScenarioTraffic(file=path.name, ego="Ego"), path.parent, RANGE_M)
    assert excesses(motion(source, 1, 30.0)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["roundabout", "winding", "motorway"])
def test_motion_on_bends_and_merges_is_feasible(name):
    """For a minute; tests/sim/sumo/test_sumo_nets.py checks the first seconds on all nets."""
    assert excesses(motion(source_on(name, RANGE_M), 1, ON_NETS_S)) == []


# ---- the checker

DT = 0.1


def run_of(*bodies):
    """Return frames with one body each."""
    return [world_frame(index, [body], dt=DT) for index, body in enumerate(bodies)]


def exceeded(frames):
    """Return the names of the limits that a run exceeds."""
    return {line.partition(":")[0] for line in excesses(worst_motion(frames, DT))}


def steady(count=4, speed=10.0):
    return run_of(*(Body(1, x=speed * DT * index, y=0.0, speed=speed) for index in range(count)))


def test_a_consistent_body_is_within_all_limits():
    assert exceeded(steady()) == set()
    assert exceeded(steady(speed=0.0)) == set()
    assert set(worst_motion(steady(), DT)) == set(LIMITS)


def test_jumps_reversing_and_creep_are_detected():
    assert exceeded(run_of(Body(1, 0, 0, speed=10), Body(1, 1.02, 0, speed=10))) == {
        "velocity off the pose difference [m/s]"
    }
    assert "reversing [m/s]" in exceeded(run_of(Body(1, 0, 0, speed=-0.5), Body(1, -0.05, 0, speed=-0.5)))
    assert "creep of a standing body [m]" in exceeded(run_of(Body(1, 0, 0), Body(1, 1e-6, 0)))
    assert "yaw rate off the yaw difference [rad/s]" in exceeded(run_of(Body(1, 0, 0), Body(1, 0, 0, yaw=0.01)))


@pytest.mark.parametrize(
    ("field", "value", "name"),
    [
        ("acceleration_world", [-10.1, 0.0], "acceleration [m/s^2]"),
        ("acceleration_world", [0.0, 6.1], "lateral acceleration [m/s^2]"),
        ("acceleration_world", [6.1, 0.0], "jerk [m/s^3]"),
        ("yaw_rate", -1.3, "yaw rate [rad/s]"),
        ("deviation", [-1.1, 0.0], "deviation along [m]"),
        ("deviation", [0.0, -1.7], "deviation across [m]"),
    ],
)
def test_each_exceeded_limit_is_detected(field, value, name):
    frames = steady()
    getattr(frames[2].actors, field)[0] = value
    found = worst_motion(frames, DT)[name]
    assert name in exceeded(frames)
    assert (found.frame, found.name) == (2, str(frames[2].actors.name[0]))


def test_a_lane_change_may_deviate_across_but_not_along():
    frames = steady()
    frames[2].actors.changes_lane[0] = True
    frames[2].actors.deviation[0] = [0.0, 3.2]
    assert exceeded(frames) == set()
    frames[2].actors.deviation[0] = [1.2, 3.2]
    assert exceeded(frames) == {"deviation along [m]"}


def test_a_new_body_may_appear_anywhere():
    assert exceeded(run_of(Body(1, 0, 0, speed=10), Body(2, 500, 0, speed=10))) == set()


def test_the_limits_apply_to_the_ego():
    frames = steady()
    frames[1].ego.acceleration_world[:] = np.array([0.0, 9.0])
    assert {"lateral acceleration [m/s^2]", "jerk [m/s^3]"} <= exceeded(frames)

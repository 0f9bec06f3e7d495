"""Scenes in SUMO: what their descriptions promise, by the ground truth of their traffic, and possible motion."""

from contextlib import closing

import numpy as np
import pytest

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import find
from luxloop.sim.factory import make_source

ACCELERATION_MAX = 10.0
"""[m/s2] More than full braking on a dry road (0.8 to 1 g)."""
GRADED_M = 50.0
"""[m] `grading.range_max_m`."""


@pytest.fixture(scope="module")
def drive():
    """Return the frames of a scenario's traffic, each played once."""
    played = {}

    def frames(name):
        if name not in played:
            scenario = Scenario.load(find(name))
            with closing(make_source(scenario.traffic, scenario.folder, 200.0)) as source:
                source.reset(scenario.seed)
                played[name] = [source.step() for _ in range(round(scenario.duration_s / source.dt))]
        return played[name]

    return frames


def beside_ego(frame, name):
    """Return a vehicle's position ahead of the ego and to its left [m]."""
    (row,) = np.flatnonzero([str(other).startswith(name) for other in frame.actors.name])
    east, north = frame.actors.pose_world[row, :2] - frame.ego.pose_world[:2]
    yaw = frame.ego.pose_world[2]
    return east * np.cos(yaw) + north * np.sin(yaw), north * np.cos(yaw) - east * np.sin(yaw)


def test_the_ambulance_passes_the_ego_between_the_queues(drive):
    frames = drive("rescue-lane")
    ahead = [beside_ego(frame, "ambulance")[0] for frame in frames]
    abreast = frames[int(np.argmin(np.abs(ahead)))]
    (row,) = np.flatnonzero(abreast.actors.name == "ambulance")
    flank = abs(beside_ego(abreast, "ambulance")[1]) - 0.5 * (abreast.actors.size[row, 1] + abreast.ego.size[1])

    assert ahead[0] < -10.0
    assert ahead[-1] > 10.0
    assert 0.2 < flank < 2.5  # between the queues, and not in a lane of its own


def test_a_tram_of_30_m_overtakes_the_ego_on_its_left(drive):
    frames = drive("tram-street")
    first, last = beside_ego(frames[0], "tram_east"), beside_ego(frames[-1], "tram_east")
    (row,) = np.flatnonzero(frames[0].actors.name == "tram_east")

    assert frames[0].actors.size[row, 0] == pytest.approx(30.0)
    assert first[0] < 0.0 < last[0]
    assert last[1] > 2.0


def test_oncoming_vehicles_are_on_the_right_where_traffic_keeps_to_the_left(drive):
    sides = []
    for frame in drive("left-hand-crossing")[::25]:
        course = frame.actors.pose_world[:, 2] - frame.ego.pose_world[2]
        oncoming = (np.cos(course) < -0.9) & (np.hypot(*frame.actors.velocity_world.T) > 1.0)
        offset = frame.actors.pose_world[oncoming, :2] - frame.ego.pose_world[:2]
        yaw = frame.ego.pose_world[2]
        ahead = offset @ (np.cos(yaw), np.sin(yaw))
        sides += (offset @ (-np.sin(yaw), np.cos(yaw)))[np.abs(ahead) < 60.0].tolist()

    assert sides
    assert max(sides) < 0.0


def test_the_work_vehicles_stand_behind_the_barrier(drive):
    frame = drive("work-zone")[0]
    parked = [str(name).startswith("site") for name in frame.actors.name]

    assert sum(parked) == 4
    top = frame.actors.pose_world[parked, 1] + 0.5 * frame.actors.size[parked, 1]
    assert (top < -3.15).all()  # the barrier of works.add.xml


@pytest.mark.parametrize("name", ["rescue-lane", "tram-street", "work-zone", "parked-lorries"])
def test_no_vehicle_appears_or_accelerates_impossibly(drive, name):
    frames = drive(name)
    known = set(map(str, frames[0].actors.name))

    for frame in frames:
        distance = np.hypot(*(frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]).T)
        new = [str(other) not in known for other in frame.actors.name]
        assert (distance[new] > GRADED_M).all()  # it enters the delivery range of 200 m, not the scene
        known |= set(map(str, frame.actors.name))
    assert max(np.hypot(*frame.actors.acceleration_world.T).max() for frame in frames) < ACCELERATION_MAX

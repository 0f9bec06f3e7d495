"""Scenarios of the catalog, played and scanned without a tracker."""

from contextlib import closing
from functools import cache

from scenarios.files.scenario import Scenario
from scenarios.files.shipped import paths
from scenarios.grading.frame_truth import FrameTruth
from scenarios.run import loop
from sensor_model.lidar import Lidar
from sensor_model.rig.rig import load_rig


def load(name, seed=None):
    """Load a scenario of the catalog, with its own seed unless another is given."""
    return Scenario.load(paths()[name], {} if seed is None else {"seed": seed})


@cache
def played(name, seed=None):
    """The obstacles and all frames of a scenario's traffic."""
    scenario = load(name, seed)
    with closing(loop._source(scenario, load_rig(str(scenario.rig), scenario.folder))) as source:
        obstacles = source.reset(scenario.seed)
        return obstacles, [source.step() for _ in range(loop._frame_count(scenario, source))]


def scans(name, when, seed=None, change=lambda frame: frame, traffic=None):
    """Yield an `FrameTruth` of each frame for which `when` holds, changed before it is scanned.

    `traffic` is a scenario of the same traffic, to play it but once.
    """
    scenario = load(name, seed)
    obstacles, frames = played(traffic or name, seed)
    rig = load_rig(str(scenario.rig), scenario.folder)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, obstacles)
    for frame in map(change, filter(when, frames)):
        yield FrameTruth.of(frame, *lidar.scan(frame), scenario.grading)


def row(frame, name):
    """Row of an actor, by its name."""
    return frame.actors.name.tolist().index(name)


def ahead(frame, name):
    """How far an actor's centre is ahead of the ego's on a road to the east [m]."""
    return frame.actors.pose_world[row(frame, name), 0] - frame.ego.pose_world[0]

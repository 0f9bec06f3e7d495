"""Catalog scenarios, simulated and scanned without a tracker."""

from contextlib import closing
from functools import cache

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import paths
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.scenarios.run import loop
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig


def load(name, seed=None):
    """Load a catalog scenario, with its own seed by default."""
    return Scenario.load(paths()[name], {} if seed is None else {"seed": seed})


@cache
def played(name, seed=None):
    """Return the obstacles and all frames of a scenario's traffic."""
    scenario = load(name, seed)
    with closing(loop._traffic(scenario, load_rig(str(scenario.rig), scenario.folder))) as source:
        obstacles = source.reset(scenario.seed)
        return obstacles, [source.step() for _ in range(round(scenario.duration_s / source.dt))]


def scans(name, when, seed=None, change=lambda frame: frame, traffic=None):
    """Yield an `FrameTruth` of each frame for which `when` holds, changed before it is scanned.

    `traffic` names a scenario with the same traffic, which is then simulated only once.
    """
    scenario = load(name, seed)
    obstacles, frames = played(traffic or name, seed)
    rig = load_rig(str(scenario.rig), scenario.folder)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, obstacles)
    for frame in map(change, filter(when, frames)):
        yield FrameTruth.of(frame, *lidar.scan(frame), scenario.grading)


def row(frame, name):
    """Return the row of an actor with this name."""
    return frame.actors.name.tolist().index(name)


def ahead(frame, name):
    """Return the distance of an actor's centre ahead of the ego's, on a road to the east [m]."""
    return frame.actors.pose_world[row(frame, name), 0] - frame.ego.pose_world[0]

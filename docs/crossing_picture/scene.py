"""Records of the scenario `sumo-crossing`, frame by frame, and their geometry in the world frame."""

from collections.abc import Iterator
from contextlib import closing
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import find
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.factory import make_source
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.geometry import rotate
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker

Floats = npt.NDArray[np.float64]

SCENARIO = "sumo-crossing"
BEGIN_S, END_S = 22.7, 30.3
"""The light turns green, the queue starts, and the ego crosses [s]."""
CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])


class Step(NamedTuple):
    """All records of one frame."""

    frame: WorldFrame
    scan: Scan
    truth: ScanTruth
    tracks: Tracks
    trace: StepTrace


def play() -> tuple[Obstacles, Iterator[Step]]:
    """Return the obstacles, and the frames from BEGIN_S to END_S."""
    scenario = Scenario.load(find(SCENARIO))
    rig = load_rig(str(scenario.rig), scenario.folder)
    source = make_source(scenario.traffic, scenario.folder, max(mount.model.range_max_m for mount in rig.mounts))
    obstacles = source.reset(scenario.seed)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, obstacles)
    tracker = Tracker(scenario.tracker)

    def steps() -> Iterator[Step]:
        with closing(source):
            for _ in range(round(END_S / source.dt)):
                frame = source.step()
                scan, truth = lidar.scan(frame)
                tracks, trace = tracker.step(scan)
                if frame.time >= BEGIN_S:
                    yield Step(frame, scan, truth, tracks, trace)

    return obstacles, steps()


def outlines(pose: Floats, size: Floats) -> Floats:
    """(N, 4, 2) corners of boxes with poses (N, 3) and sizes (N, 2 or 3) [m, rad]."""
    yaw = np.repeat(pose[:, 2], 4)
    corners = 0.5 * CORNERS * size[:, None, :2]
    return pose[:, None, :2] + rotate(corners.reshape(-1, 2), yaw).reshape(-1, 4, 2)


def to_world(step: Step, points: Floats, pose_of_ego: Floats) -> Floats:
    """(N, 2) points of a frame in which the ego has `pose_of_ego` (3,), in the world frame [m]."""
    turn = step.frame.ego.pose_world[2] - pose_of_ego[2]
    offset = points[:, :2] - pose_of_ego[:2]
    return step.frame.ego.pose_world[:2] + rotate(offset, np.full(len(points), turn))


def heading_errors(step: Step, row: int) -> dict[str, float]:
    """Return the absolute heading errors of the nearest fit, modulo 90, and the nearest track, modulo 360 [deg]."""
    pose, ego, odom = step.frame.actors.pose_world[row], step.frame.ego.pose_world, step.scan.ego_pose_odom
    fits, tracks = step.trace.boxes, step.tracks
    fit = nearest(to_world(step, fits.center_ego, np.zeros(3)), pose)
    track = nearest(to_world(step, tracks.center_odom, odom), pose)
    of_fit = np.rad2deg(fits.heading[fit] + ego[2] - pose[2])
    of_track = np.rad2deg(tracks.mean[track, 6] + ego[2] - odom[2] - pose[2])
    return {"fit": abs((of_fit + 45.0) % 90.0 - 45.0), "track": abs((of_track + 180.0) % 360.0 - 180.0)}


def nearest(points: Floats, pose: Floats) -> int:
    """Return the row of the point nearest to a pose."""
    return int(np.linalg.norm(points - pose[:2], axis=1).argmin())

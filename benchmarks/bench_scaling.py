"""Processor time of a frame against the number of vehicles and of LIDARs, stage by stage, without recording.

Vehicles follow the ego on a motorway of five lanes; the fewer ones of a run are a random choice of the 100 of the
longest queue, so that the range of distances is the same.
"""

from collections.abc import Iterator
from dataclasses import replace
from time import thread_time
from typing import Any

import numpy as np

from benchmarks.bench_sensor import NO_OBSTACLES, RIG, TRAFFIC, motorway, thinned
from luxloop.scenarios.grading.body_points import Ranging
from luxloop.scenarios.grading.grader import Grader
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.world import WorldFrame
from luxloop.tracker.tracker import Tracker, TrackerConfig

UNITS = (1, 2, 4, 6)
USUAL = 50
"""Vehicles of the runs with fewer LIDARs."""
DT_S = 0.08
FRAMES, FIRST_TIMED = 60, 20
STAGES = ("sensor", "tracker", "grading")


def rows() -> dict[str, dict[str, Any]]:
    """Return the median time of each stage for each number of vehicles and of LIDARs."""
    found: dict[str, dict[str, Any]] = {}
    for vehicles in TRAFFIC:
        found |= _named(f"{vehicles}veh", stage_times(RIG, vehicles))
    for units in UNITS:
        found |= _named(f"{units}units", stage_times(replace(RIG, mounts=RIG.mounts[:units]), USUAL))
    return found


def _named(end: str, measured: dict[str, float]) -> dict[str, dict[str, Any]]:
    points = f"{measured.pop('points'):.0f} points a scan"
    return {
        f"scaling.{stage}_ms_{end}": {"value": value, "unit": "ms", "peer": points, "ratio": None}
        for stage, value in measured.items()
    }


def stage_times(rig: Rig, vehicles: int) -> dict[str, float]:
    """Return the median processor time of each stage per frame [ms], and the mean number of points as `points`."""
    lidar = Lidar(rig, NoiseConfig(), SensorConfig(), seed=1, obstacles=NO_OBSTACLES)
    tracker, grader = Tracker(TrackerConfig()), Grader(GradingConfig(), Ranging.of(rig, NoiseConfig()))
    times, points = [], []
    for frame in platoon(vehicles):
        begin = thread_time()
        scan, truth = lidar.scan(frame)
        scanned = thread_time()
        tracks, trace = tracker.step(scan)
        tracked = thread_time()
        grader.add(frame, scan, truth, tracks, trace)
        times.append(np.diff([begin, scanned, tracked, thread_time()]))
        points.append(len(scan))
    medians = 1e3 * np.median(times[FIRST_TIMED:], axis=0)
    return {**dict(zip(STAGES, medians.tolist(), strict=True)), "points": float(np.mean(points[FIRST_TIMED:]))}


def platoon(vehicles: int) -> Iterator[WorldFrame]:
    """Yield the frames of vehicles that drive at 29 to 31 m/s beside an ego at 30 m/s."""
    frame = thinned(motorway(max(TRAFFIC)), vehicles)
    speed = np.random.default_rng(5).uniform(29.0, 31.0, vehicles)
    velocity = np.column_stack([speed, np.zeros(vehicles)])
    still = np.zeros_like(velocity)
    pose = frame.actors.pose_world * (1.0, 1.0, 0.0)
    for index in range(FRAMES):
        way = np.append(velocity, np.zeros((vehicles, 1)), axis=1) * DT_S * index
        actors = replace(
            frame.actors,
            pose_world=pose + way,
            velocity_world=velocity,
            acceleration_world=still,
            yaw_rate=np.zeros(vehicles),
        )
        place = frame.ego.pose_world + np.array([30.0 * DT_S * index, 0.0, 0.0])
        ego = replace(frame.ego, pose_world=place, yaw_rate=0.0)
        yield WorldFrame(index, DT_S * index, ego, actors)

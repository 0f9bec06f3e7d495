"""Complete loop on the SUMO crossing: traffic, LIDARs, tracker and grading, without recording, on one core."""

import time
from typing import Any

import numpy as np

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import find
from luxloop.scenarios.grading.grader import Grader
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.tracker.tracker import Tracker

VEHICLES = 30
RANGE_M = 60.0
"""[m] Range of the tracker; only frames with at least `VEHICLES` vehicles within it count."""
SCENARIO = "sumo-crossing"


def rows() -> dict[str, dict[str, Any]]:
    """Time the scenario with its default footprint, and with one ray per beam."""
    rows = loop_rows({})
    centre_ray = loop_rows({"sensor": {"footprint": [1, 1]}})
    return {**rows, "loop.realtime_factor_30veh_centre_ray": centre_ray["loop.realtime_factor_30veh"]}


def loop_rows(overrides: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Time the loop; only frames with dense traffic count."""
    scenario = Scenario.load(find(SCENARIO), overrides)
    rig = load_rig(str(scenario.rig), scenario.folder)
    source = SumoSource(scenario.traffic, scenario.folder, range_m=200.0)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, source.reset(scenario.seed))
    tracker, grader = Tracker(scenario.tracker), Grader(scenario.grading)
    sim_s, sensor_s, tracker_s, grading_s = [], [], [], []
    for _ in range(round(scenario.duration_s / source.dt)):
        begin = time.perf_counter()
        frame = source.step()
        delivered = time.perf_counter()
        scan, truth = lidar.scan(frame)
        scanned = time.perf_counter()
        tracks, trace = tracker.step(scan)
        tracked = time.perf_counter()
        grader.add(frame, scan, truth, tracks, trace)
        graded = time.perf_counter()
        offset = frame.actors.pose_world[:, :2] - frame.ego.pose_world[:2]
        if np.count_nonzero(np.hypot(*offset.T) <= RANGE_M) >= VEHICLES:
            sim_s.append(delivered - begin)
            sensor_s.append(scanned - delivered)
            tracker_s.append(tracked - scanned)
            grading_s.append(graded - tracked)
    source.close()
    factor = source.dt / np.mean(np.sum([sim_s, sensor_s, tracker_s, grading_s], axis=0))
    crowded = f"{len(sim_s)} frames with {VEHICLES} or more vehicles within {RANGE_M:.0f} m"
    return {
        "loop.realtime_factor_30veh": {"value": factor, "unit": "1", "peer": crowded, "ratio": None},
        "tracker.step_30veh_ms_p99": milliseconds(np.percentile(tracker_s, 99)),
        "traffic.step_ms_p50": milliseconds(np.median(sim_s)),
        "loop.sensor_ms_30veh": milliseconds(np.mean(sensor_s)),
        "loop.tracker_ms_30veh": milliseconds(np.mean(tracker_s)),
        "loop.grading_ms_30veh": milliseconds(np.mean(grading_s)),
        "loop.traffic_ms_30veh": milliseconds(np.mean(sim_s)),
    }


def milliseconds(seconds: float) -> dict[str, Any]:
    """Return a row with a time [s] in milliseconds."""
    return {"value": 1e3 * float(seconds), "unit": "ms", "peer": None, "ratio": None}

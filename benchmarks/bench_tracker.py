"""Time of a tracker step with four vehicles in view, the load of the paper."""

import time
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import find
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.tracker.tracker import Tracker

FRAMES = 200
PLACES_M = ((12.0, 0.0), (20.0, 3.5), (-15.0, -3.5), (9.0, -7.0))


def rows() -> dict[str, dict[str, Any]]:
    """Return the median over a stationary scripted scene."""
    rig = load_rig("srx_six_lux", Path())
    traffic = ScriptedTraffic(
        kind="scripted",
        ego=ScriptedEgo(),
        actor=[ScriptedActor(name=f"car {i}", x_m=x, y_m=y) for i, (x, y) in enumerate(PLACES_M)],
    )
    source = ScriptedSource(traffic, Path(), range_m=200.0)
    scenario = Scenario.load(find("ring"))
    lidar = Lidar(rig, scenario.noise, scenario.sensor, 1, source.reset(1))
    tracker, spent = Tracker(), []
    for _ in range(FRAMES):
        scan, _ = lidar.scan(source.step())
        begin = time.perf_counter()
        tracker.step(scan)
        spent.append(time.perf_counter() - begin)
    value = 1e3 * float(np.median(spent))
    return {"tracker.step_4obs_ms_p50": {"value": value, "unit": "ms", "peer": None, "ratio": None}}

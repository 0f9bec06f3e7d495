"""Frames of a scenario with all records of sensor and tracker, for pictures."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from luxloop.scenarios.files.scenario import Scenario
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.factory import make_source
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker


class Step(NamedTuple):
    """All records of one frame."""

    frame: WorldFrame
    scan: Scan
    truth: ScanTruth
    tracks: Tracks
    trace: StepTrace
    obstacles: Obstacles


def steps(path: Path, end_s: float | None = None) -> Iterator[Step]:
    """Run a scenario file with the shipped tracker up to a simulated time, by default to its end."""
    scenario = Scenario.load(path)
    rig = load_rig(str(scenario.rig), scenario.folder)
    range_m = max(mount.model.range_max_m for mount in rig.mounts)
    with closing(make_source(scenario.traffic, scenario.folder, range_m)) as source:
        obstacles = source.reset(scenario.seed)
        lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, obstacles)
        tracker = Tracker(scenario.tracker)
        for _ in range(round((scenario.duration_s if end_s is None else end_s) / source.dt)):
            frame = source.step()
            scan, truth = lidar.scan(frame)
            tracks, trace = tracker.step(scan)
            yield Step(frame, scan, truth, tracks, trace, obstacles)

"""Cost of a frame, time to the first frame and memory against the size of the city, with equal traffic around the ego.

Three grids have one vehicle per edge, which starts at a place and takes a route that depend only on its edge, counted
from the ego's junction in the middle. Each grid runs in a process of its own, so that its peak of memory is known.
Times are processor times, which other processes on the machine hardly change.
"""

import json
import subprocess
import sys
import tempfile
from contextlib import closing
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np

from benchmarks.grid_net import Place, edge, neighbours, write_grid

COLUMNS = (8, 20, 51)
"""224, 1520 and 10 200 edges."""
ROUTE_EDGES = 30
SETTLE, FRAMES = 60, 100
RANGE_M = 200.0
"""[m] Longest range of the units of the default rig."""
STAGES = ("traffic", "sensor", "tracker", "grading")
VEHICLE_TYPE = '<vType id="exact" sigma="0" speedDev="0"/>'
"""Drivers without SUMO's random numbers, which would depend on the net."""


def rows() -> dict[str, dict[str, Any]]:
    """Return the figures of all grids; the ratio of the frame is that to the smallest grid."""
    found: dict[str, dict[str, Any]] = {}
    smallest = 0.0
    for columns in COLUMNS:
        figures = _in_own_process(columns)
        edges = figures["edges"]
        frame = sum(figures[stage] for stage in STAGES)
        smallest = smallest or frame
        crowd = f"{figures['vehicles']} vehicles, {figures['near']:.1f} of them in range"
        parts = ", ".join(f"{stage} {figures[stage]:.1f}" for stage in STAGES)
        found |= {
            f"city.frame_ms_{edges}edges": _row(frame, "ms", f"{parts}; {crowd}", frame / smallest),
            f"city.traffic_ms_{edges}edges": _row(figures["traffic"], "ms", "without SUMO's step"),
            f"city.sumo_step_ms_{edges}edges": _row(figures["sumo"], "ms", "in a process of its own"),
            f"city.first_frame_s_{edges}edges": _row(
                figures["first_frame"],
                "s",
                f"net of {figures['net_mb']:.1f} MB; SUMO start {figures['start']:.1f} s, steps {figures['steps']:.1f}",
            ),
            f"city.memory_mb_{edges}edges": _row(figures["memory"], "MB", "SUMO and its source, above an empty net"),
        }
    return found


def _row(value: float, unit: str, peer: str, ratio: float | None = None) -> dict[str, Any]:
    return {"value": value, "unit": unit, "peer": peer, "ratio": ratio}


def _in_own_process(columns: int) -> dict[str, Any]:
    command = [sys.executable, "-m", "benchmarks.bench_city", str(columns)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, cwd=Path(__file__).parent.parent)
    figures: dict[str, Any] = json.loads(done.stdout)
    return figures


def measure(columns: int) -> dict[str, float]:
    """Return the figures of one grid: median times per frame [ms], of the start [s], memory [MB] and numbers."""
    from luxloop.sim.sumo.sumo_source import SumoSource

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        vehicles = write_city(folder, columns)
        traffic = _traffic()
        _load_libraries(folder, traffic)
        before = _peak_mb()
        with closing(SumoSource(traffic, folder, RANGE_M)) as source, _SumoClock() as clock:
            begin = thread_time()
            obstacles = source.reset(1)
            source.step()
            first_frame, steps = thread_time() - begin, clock.steps_s
            memory = _peak_mb() - before
            times, near = _frames(source, obstacles, clock)
        net_mb = (folder / "city.net.xml").stat().st_size / 1e6
    return {
        **dict(zip(("sumo", *STAGES), times.tolist(), strict=True)),
        "edges": 4 * columns * (columns - 1),
        "vehicles": vehicles,
        "near": near,
        "first_frame": first_frame,
        "start": clock.start_s,
        "steps": steps,
        "memory": memory,
        "net_mb": net_mb,
    }


def write_city(folder: Path, columns: int) -> int:
    """Write net and routes of a grid, and return the number of vehicles."""
    write_grid(folder / "city.net.xml", columns)
    middle = (columns // 2, columns // 2)
    places = [(column, row) for column in range(columns) for row in range(columns)]
    starts = [(place, ahead) for place in places for ahead in neighbours(place, columns)]
    with (folder / "city.rou.xml").open("w") as stream:
        stream.write(f"<routes>{VEHICLE_TYPE}\n")
        for place, ahead in starts:
            stream.write(_vehicle(place, ahead, middle, columns))
        stream.write("</routes>\n")
    return len(starts)


def _vehicle(place: Place, ahead: Place, middle: Place, columns: int) -> str:
    """Return the vehicle of an edge; its random numbers depend on the place of the edge from the middle."""
    way = (ahead[0] - place[0], ahead[1] - place[1])
    rng = np.random.default_rng([place[0] - middle[0] + 99, place[1] - middle[1] + 99, way[0] + 1, way[1] + 1])
    name = "ego" if place == middle and way == (1, 0) else edge(place, ahead)
    position, edges = rng.uniform(10.0, 120.0), [edge(place, ahead)]
    for draw in rng.random(ROUTE_EDGES - 1):
        onward = [other for other in neighbours(ahead, columns) if other != place]
        place, ahead = ahead, onward[int(draw * len(onward))]
        edges.append(edge(place, ahead))
    return (
        f'<vehicle id="{name}" type="exact" depart="0" departPos="{position:.2f}" departSpeed="0">'
        f'<route edges="{" ".join(edges)}"/></vehicle>\n'
    )


def _traffic() -> Any:
    from luxloop.sim.sumo.sumo_config import SumoTraffic

    return SumoTraffic(net="city.net.xml", routes=["city.rou.xml"], ego="vehicle:ego")


def _load_libraries(folder: Path, traffic: Any) -> None:
    """Run the smallest grid once, so that libraries count neither as time nor as memory of the net."""
    from luxloop.sim.sumo.sumo_source import SumoSource

    small = folder / "small"
    small.mkdir()
    write_city(small, 5)
    with closing(SumoSource(traffic, small, RANGE_M)) as source:
        source.reset(1)
        source.step()


def _frames(source: Any, obstacles: Any, clock: "_SumoClock") -> tuple[np.ndarray, float]:
    """Return median times [ms] of SUMO's step and of the stages, and the mean number of vehicles in range."""
    from luxloop.scenarios.grading.body_points import Ranging
    from luxloop.scenarios.grading.grader import Grader
    from luxloop.scenarios.grading.grading_config import GradingConfig
    from luxloop.sensor_model.lidar import Lidar
    from luxloop.sensor_model.noise.noise_config import NoiseConfig
    from luxloop.sensor_model.rig.rig import load_rig
    from luxloop.sensor_model.sensor_config import SensorConfig
    from luxloop.tracker.tracker import Tracker, TrackerConfig

    rig, noise = load_rig("srx_six_lux", Path()), NoiseConfig()
    lidar = Lidar(rig, noise, SensorConfig(), seed=1, obstacles=obstacles)
    tracker, grader = Tracker(TrackerConfig()), Grader(GradingConfig(), Ranging.of(rig, noise))
    times, near = [], []
    for _ in range(SETTLE + FRAMES):
        clock.steps_s = 0.0
        ends = [thread_time()]
        frame = source.step()
        ends.append(thread_time())
        scan, truth = lidar.scan(frame)
        ends.append(thread_time())
        tracks, trace = tracker.step(scan)
        ends.append(thread_time())
        grader.add(frame, scan, truth, tracks, trace)
        ends.append(thread_time())
        stages = np.diff(ends)
        times.append([clock.steps_s, stages[0] - clock.steps_s, *stages[1:]])
        near.append(len(frame.actors))
    return 1e3 * np.median(times[SETTLE:], axis=0), float(np.mean(near[SETTLE:]))


class _SumoClock:
    """Processor time that SUMO itself takes inside a source: its start, and its steps since they were last reset."""

    def __enter__(self) -> "_SumoClock":
        import libsumo

        self.start_s, self.steps_s = 0.0, 0.0
        self._sumo, self._start, self._step = libsumo, libsumo.start, libsumo.simulationStep
        libsumo.start, libsumo.simulationStep = self._timed_start, self._timed_step
        return self

    def __exit__(self, *_: object) -> None:
        self._sumo.start, self._sumo.simulationStep = self._start, self._step

    def _timed_start(self, *arguments: Any) -> Any:
        begin = thread_time()
        done = self._start(*arguments)
        self.start_s += thread_time() - begin
        return done

    def _timed_step(self, *arguments: Any) -> Any:
        begin = thread_time()
        done = self._step(*arguments)
        self.steps_s += thread_time() - begin
        return done


def _peak_mb() -> float:
    """Return the peak of this process's resident memory [MB]."""
    import resource

    kilobytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return kilobytes / (1e6 if sys.platform == "darwin" else 1e3)


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))

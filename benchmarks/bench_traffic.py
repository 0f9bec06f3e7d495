"""Overhead of world frames over SUMO's step, in a city with more than 5000 vehicles at the same time.

`city.net.xml.xz` was built with SUMO 1.28 by

    netgenerate --grid --grid.number 20 --grid.length 150 --no-turnarounds --output-file city.net.xml

The comment at its head is removed, and the file is compressed with `xz -9`.
"""

import lzma
import string
import tempfile
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import libsumo
import numpy as np

from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

NET = Path(__file__).parent / "city.net.xml.xz"
COLUMNS = 20
VEHICLES = 5300
EDGES = 30
"""Edges per route."""
SETTLE, FRAMES = 60, 150
RANGE_M = 200.0
"""[m] Longest range of the units of the default rig."""


def rows() -> dict[str, dict[str, Any]]:
    """Time the same traffic twice: as a source of frames, and in SUMO alone."""
    with tempfile.TemporaryDirectory() as folder:
        config = _city(Path(folder))
        with closing(SumoSource(config, Path(folder), RANGE_M)) as source:
            source.reset(1)
            step_s, frame_s, on_the_road, near = _frames(source)
        alone_s = _alone(Path(folder))
    step_ms, alone_ms, overhead_ms = (
        1e3 * float(np.median(seconds)) for seconds in (step_s, alone_s, frame_s - step_s)
    )
    crowd = f"{min(on_the_road)} vehicles or more, {np.mean(near):.0f} of them in range"
    return {
        "traffic.overhead_ms": {
            "value": overhead_ms,
            "unit": "ms",
            "peer": f"SUMO's step, {step_ms:.1f} ms; {crowd}",
            "ratio": step_ms / overhead_ms,
        },
        "traffic.sumo_step_ms": {
            "value": step_ms,
            "unit": "ms",
            "peer": f"without subscriptions, {alone_ms:.1f} ms",
            "ratio": alone_ms / step_ms,
        },
    }


def _frames(source: SumoSource) -> tuple[np.ndarray, np.ndarray, list[int], list[int]]:
    """Return times [s] of SUMO's step and of each whole frame, and numbers of vehicles in the net and in range."""
    step, steps_s = libsumo.simulationStep, []

    def timed(*arguments: Any) -> Any:
        begin = time.perf_counter()
        done = step(*arguments)
        steps_s.append(time.perf_counter() - begin)
        return done

    frame_s, on_the_road, near = [], [], []
    libsumo.simulationStep = timed
    try:
        for index in range(SETTLE + FRAMES):
            steps_s.clear()
            begin = time.perf_counter()
            frame = source.step()
            whole = time.perf_counter() - begin
            if index >= SETTLE:
                frame_s.append((sum(steps_s), whole))
                on_the_road.append(libsumo.vehicle.getIDCount())
                near.append(len(frame.actors))
    finally:
        libsumo.simulationStep = step
    step_s, whole_s = np.array(frame_s).T
    return step_s, whole_s, on_the_road, near


def _alone(folder: Path) -> list[float]:
    """Return times [s] of SUMO's steps without subscriptions."""
    files = ["--net-file", str(folder / "city.net.xml"), "--route-files", str(folder / "city.rou.xml")]
    libsumo.start(["sumo", *files, "--step-length", "0.08", "--seed", "1", "--no-step-log", "--no-warnings"])
    seconds = []
    for _ in range(SETTLE + FRAMES):
        begin = time.perf_counter()
        libsumo.simulationStep()
        seconds.append(time.perf_counter() - begin)
    libsumo.close()
    return seconds[SETTLE:]


def _city(folder: Path) -> SumoTraffic:
    """Write the city's files, with vehicles that all depart at time 0 at random positions."""
    (folder / "city.net.xml").write_bytes(lzma.decompress(NET.read_bytes()))
    rng = np.random.default_rng(1)
    vehicles = "".join(
        f'<vehicle id="{"ego" if index == 0 else index}" depart="0" departPos="random_free" departSpeed="0">'
        f'<route edges="{" ".join(_route(rng))}"/></vehicle>\n'
        for index in range(VEHICLES)
    )
    (folder / "city.rou.xml").write_text(f"<routes>\n{vehicles}</routes>\n")
    return SumoTraffic(net="city.net.xml", routes=["city.rou.xml"], ego="vehicle:ego")


def _route(rng: np.random.Generator) -> list[str]:
    """Return a random route over the grid without U-turns."""
    ways = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    place, heading = rng.integers(COLUMNS, size=2), rng.integers(4)
    edges: list[str] = []
    while len(edges) < EDGES:
        turns = [turn for turn in (0, 1, 3) if _inside(place + ways[(heading + turn) % 4])]
        if not turns:  # only possible at the start of a route
            heading = rng.integers(4)
            continue
        heading = (heading + rng.choice(turns)) % 4
        ahead = place + ways[heading]
        edges.append(_junction(place) + _junction(ahead))
        place = ahead
    return edges


def _inside(place: np.ndarray) -> bool:
    return bool(((place >= 0) & (place < COLUMNS)).all())


def _junction(place: np.ndarray) -> str:
    return f"{string.ascii_uppercase[place[0]]}{place[1]}"

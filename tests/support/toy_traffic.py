"""Traffic sources for tests of the worker process: fast, deterministic, with selectable failures."""

import errno
import importlib
import os
import signal
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from luxloop.sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError, TrafficSource
from luxloop.sim.world import Actors, Ego, Obstacles, WorldFrame


def walk(index: int, dt: float, count: int, rng: np.random.Generator, speed: float) -> WorldFrame:
    """Return a frame of `count` actors at random positions; the ego has the commanded speed."""
    ego = Ego(
        pose_world=rng.normal(size=3),
        velocity_world=np.array([speed, 0.0]),
        acceleration_world=np.zeros(2),
        yaw_rate=float(rng.normal()),
        size=np.array([4.8, 1.9, 1.7]),
        changes_lane=False,
        deviation=np.zeros(2),
        ground_z=0.0,
        attitude=np.zeros(2),
    )
    actors = Actors(
        id=np.arange(1, count + 1),
        name=np.array([f"vehicle.{row}" for row in range(count)], dtype=np.str_),
        kind=np.zeros(count, np.uint8),
        pose_world=rng.normal(size=(count, 3)),
        velocity_world=rng.normal(size=(count, 2)),
        acceleration_world=rng.normal(size=(count, 2)),
        yaw_rate=rng.normal(size=count),
        articulation=np.zeros(count),
        mode=np.zeros(count, np.uint8),
        changes_lane=np.zeros(count, np.bool_),
        deviation=np.zeros((count, 2)),
        ground_z=np.zeros(count),
        attitude=np.zeros((count, 2)),
        size=rng.uniform(1.0, 5.0, size=(count, 3)),
        reflectivity=np.full(count, 0.5),
    )
    return WorldFrame(index, index * dt, ego, actors)


@dataclass
class ToyTraffic:
    """Actors at random positions. The selected failure happens at frame `last`."""

    failure: str = ""
    last: int = 10
    count: int = 100
    report: str = ""
    """Path of a file that gets a line for every step and for the end."""
    litter: bool = False
    """Leave a temporary file behind."""
    imports: str = ""
    """Module to import at the start."""
    dt: float = 0.08
    origin: np.ndarray = field(default_factory=lambda: np.array([10_000.0, -20_000.0]))
    ego_name: str = "toy"
    warnings: tuple[str, ...] = ("toy",)

    def reset(self, seed: int) -> Obstacles:
        self.next, self.speed, self.rng = 0, 0.0, np.random.default_rng(seed)
        self.log(f"process {os.getpid()}")
        if self.imports:
            importlib.import_module(self.imports)
        if self.litter:
            tempfile.NamedTemporaryFile(suffix=".litter", delete=False).close()
        if self.failure == "no start":
            raise TrafficInputError(f"toy: seed {seed} is not there; choose another")
        if self.failure == "died at start":
            os.kill(os.getpid(), signal.SIGSEGV)
        return Obstacles.from_polygons([np.eye(2) * seed], [3.0])

    def step(self) -> WorldFrame:
        self.log(f"step {self.next}")
        if self.next == self.last:
            self.fail()
        frame = walk(self.next, self.dt, self.count, self.rng, self.speed)
        self.next += 1
        return frame

    def fail(self) -> None:
        match self.failure:
            case "ended":
                raise TrafficEndedError("the ego arrived at 0.80 s")
            case "failed":
                raise SimulatorFailedError("toy at 0.80 s: no more")
            case "refused":
                raise PermissionError(errno.EACCES, "Permission denied", "cars.csv")
            case "bug":
                raise ZeroDivisionError("one over nothing")
            case "exit":
                print("to standard output", flush=True)
                print("Error: too many cars\n", file=sys.stderr, flush=True)
                os._exit(7)
            case "crash":
                os.kill(os.getpid(), signal.SIGSEGV)
            case "killed":
                os.kill(os.getpid(), signal.SIGKILL)
            case "stuck":
                time.sleep(60.0)

    def apply(self, command: EgoCommand) -> None:
        if command.speed_mps is None:
            raise TrafficInputError("toy: give a speed")
        self.speed = command.speed_mps

    def close(self) -> None:
        self.log("closed")

    def log(self, line: str) -> None:
        if self.report:
            with Path(self.report).open("a") as file:
                file.write(line + "\n")


class Inventory:
    """Wrapper that ends after the first frame with the loaded modules of its process as the message."""

    def __init__(self, source: TrafficSource):
        self.dt, self.origin, self.warnings, self.ego_name = source.dt, np.zeros(2), (), ""
        self.source = source

    def reset(self, seed: int) -> Obstacles:
        return self.source.reset(seed)

    def step(self) -> WorldFrame:
        self.source.step()
        raise TrafficEndedError(" ".join(sys.modules))

    def close(self) -> None:
        self.source.close()

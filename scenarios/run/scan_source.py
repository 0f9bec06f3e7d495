"""Traffic and LIDARs as one source of scans, in this process or ahead of the tracker in a worker process.

The worker unpickles a `ScanSource`, so this module imports neither tracker nor grading.
"""

import time
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from luxloop.scenarios.run.warm_up import FRAMES, car_ahead, compilation_reported
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.source import EgoCommand, StartReport, TrafficInputError, TrafficSource, ignore_status, watch_start
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.scan import Scan


class NoiseInputError(TrafficInputError):
    """The noise does not fit the rig."""


@dataclass(frozen=True, slots=True)
class ScannedFrame:
    """A frame of the world and its scan."""

    frame: WorldFrame
    scan: Scan
    truth: ScanTruth
    sim_s: float
    """Time that the traffic took [s]."""
    sensor_s: float
    """Time that the LIDARs took [s]."""


@dataclass(frozen=True, slots=True)
class ScanStart:
    """Start of a run."""

    obstacles: Obstacles
    warm_up: list[ScannedFrame]
    """Scans of one car that are not part of the run, to warm up a tracker."""


class ScanSource:
    """A traffic source, and the LIDARs that scan its frames.

    Parameters
    ----------
    traffic
        Traffic source, not yet reset.
    rig, noise, sensor
        As `luxloop.sensor_model.lidar.Lidar`.
    """

    def __init__(self, traffic: TrafficSource, rig: Rig, noise: NoiseConfig, sensor: SensorConfig) -> None:
        self.dt = traffic.dt
        self.origin = np.zeros(2)
        self.warnings: tuple[str, ...] = ()
        self.ego_name = ""
        self.report_start: StartReport = ignore_status
        """Receives the progress of `reset`."""
        self._traffic, self._rig, self._noise, self._sensor = traffic, rig, noise, sensor
        self._lidar: Lidar | None = None

    def reset(self, seed: int) -> ScanStart:
        """Start a new run: traffic first, then the LIDARs, whose kernels are compiled here.

        Raises
        ------
        TrafficInputError, SimulatorFailedError
            As `luxloop.sim.source.TrafficSource.reset`.
        NoiseInputError
            The noise names a unit that the rig does not have.
        """
        watch_start(self._traffic, self.report_start)
        with compilation_reported(self.report_start):
            return self._start(seed)

    def _start(self, seed: int) -> ScanStart:
        obstacles = self._traffic.reset(seed)
        self.origin, self.warnings, self.ego_name = self._traffic.origin, self._traffic.warnings, self._traffic.ego_name
        try:
            self._lidar = Lidar(self._rig, self._noise, self._sensor, seed, obstacles)
        except ValueError as error:
            raise NoiseInputError(str(error)) from error
        return ScanStart(obstacles, [*_warm_up_scans(self._rig, self._noise, self._sensor)])

    def step(self) -> ScannedFrame:
        """Return the next frame and its scan. Errors as `luxloop.sim.source.TrafficSource.step`."""
        assert self._lidar is not None
        begin = time.perf_counter()
        frame = self._traffic.step()
        delivered = time.perf_counter()
        scan, truth = self._lidar.scan(frame)
        return ScannedFrame(frame, scan, truth, delivered - begin, time.perf_counter() - delivered)

    def apply(self, command: EgoCommand) -> None:
        """Command the ego. See `luxloop.sim.source.TrafficSource.apply`."""
        self._traffic.apply(command)

    def close(self) -> None:
        """Release the simulator."""
        self._traffic.close()


@lru_cache(maxsize=4)
def _warm_up_scans(rig: Rig, noise: NoiseConfig, sensor: SensorConfig) -> tuple[ScannedFrame, ...]:
    """Return scans of one car, by LIDARs that are not used again. Runs with the same LIDARs share them."""
    wall = np.array([[-20.0, 15.0], [20.0, 15.0]])
    obstacles = Obstacles.from_polygons([wall], [3.0])
    lidar = Lidar(rig, noise, sensor, seed=0, obstacles=obstacles)
    frames = [car_ahead(index) for index in range(FRAMES)]
    return tuple(ScannedFrame(frame, *lidar.scan(frame), sim_s=0.0, sensor_s=0.0) for frame in frames)


class Scans(Protocol):
    """A `ScanSource`, or a process that runs one ahead."""

    dt: float
    """Time between frames [s]."""
    warnings: tuple[str, ...]
    """As `luxloop.sim.source.TrafficSource`."""
    ego_name: str
    """As `luxloop.sim.source.TrafficSource`."""
    report_start: StartReport
    """Receives the progress of `reset`."""

    def reset(self, seed: int) -> ScanStart:
        """See `ScanSource.reset`."""
        ...

    def step(self) -> ScannedFrame:
        """See `ScanSource.step`."""
        ...

    def close(self) -> None:
        """See `ScanSource.close`."""
        ...

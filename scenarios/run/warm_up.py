"""Warm-up before the time measurement starts: a frame with one car, and the report of compilations."""

import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numba.core import event

from luxloop.scenarios.run import progress
from luxloop.scenarios.run.containment import START_FACTOR, STEP_TIMEOUT_S
from luxloop.scenarios.run.guard import guarded
from luxloop.sensor_model.rig.beams import beam_table, sweep_limits
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sim.rare_collection import collect_rarely
from luxloop.sim.source import StartReport, StartStatus
from luxloop.sim.world import Actors, Ego, Kind, WorldFrame
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig

FRAMES = 3
"""Enough to start, update and confirm a track."""


def car_ahead(index: int) -> WorldFrame:
    """Return a frame with a turning car, 8 m in front of a standing ego."""
    ego = Ego(
        pose_world=np.zeros(3),
        velocity_world=np.zeros(2),
        acceleration_world=np.zeros(2),
        yaw_rate=0.0,
        size=np.array([4.8, 1.9, 1.7]),
        changes_lane=False,
        deviation=np.zeros(2),
        ground_z=0.0,
        attitude=np.zeros(2),
    )
    car = Actors(
        id=np.array([1]),
        name=np.array(["car"]),
        kind=np.array([Kind.CAR], dtype=np.uint8),
        pose_world=np.array([[8.0 + 0.5 * index, 2.0, 0.5]]),
        velocity_world=np.array([[6.0, 0.0]]),
        acceleration_world=np.zeros((1, 2)),
        yaw_rate=np.zeros(1),
        articulation=np.zeros(1),
        mode=np.zeros(1, np.uint8),
        changes_lane=np.zeros(1, np.bool_),
        deviation=np.zeros((1, 2)),
        ground_z=np.zeros(1),
        attitude=np.full((1, 2), 0.01),  # a level body is not tilted
        size=np.array([[4.5, 1.8, 1.5]]),
        reflectivity=np.array([0.5]),
    )
    return WorldFrame(index, 0.08 * index, ego, car)


COMPILATION = "numba:compile"
"""numba's event; a kernel that is loaded from the cache has none."""
STATUS = StartStatus("compiling numba kernels, up to two minutes, only once")


@contextmanager
def compilation_reported(report: StartReport) -> Iterator[None]:
    """Report each kernel that this process compiles inside this context."""
    with event.install_listener(COMPILATION, _Listener(report)):
        yield


class _Listener(event.Listener):
    """Reports the start of each compilation."""

    def __init__(self, report: StartReport) -> None:
        self._report = report

    def on_start(self, _: Any) -> None:
        self._report(STATUS)

    def on_end(self, _: Any) -> None:
        """Ignore the end: the next kernel follows."""


@contextmanager
def tracker_beside(config: TrackerConfig, rig: Rig) -> Iterator[None]:
    """Compile the shipped tracker in another process, and wait for it at the end.

    A failure there is not reported: this process compiles the rest when it uses it, and meets the same failure.
    """
    beside = multiprocessing.get_context("spawn").Process(target=_compile, args=(config, rig), daemon=True)
    beside.start()
    try:
        yield
        with progress.start("tracker") as report:
            report(STATUS)
            beside.join()
    finally:
        beside.kill()


def _compile(config: TrackerConfig, rig: Rig) -> None:
    """Run the shipped tracker for a few scans of one car."""
    collect_rarely()
    with guarded(Tracker, config, START_FACTOR * STEP_TIMEOUT_S, "warm-up, ") as tracker:
        for index in range(FRAMES):
            scan = _car_ahead(index, rig)
            tracker.checked(tracker.step(scan), scan)


def _car_ahead(index: int, rig: Rig) -> Scan:
    """Return points on the rear and the left side of a car ahead, and on the ground, in all layers."""
    beams = beam_table(rig)
    rear, side = np.linspace(-0.9, 0.9, 25), np.linspace(0.0, 4.5, 40)
    x = np.concatenate([np.full(25, 8.0), 8.0 + side, np.linspace(3.0, 7.0, 20)]) + 0.5 * index
    y = np.concatenate([rear, np.full(40, 0.9), np.full(20, -4.0)])
    z = np.concatenate([np.full(65, 0.5), np.zeros(20)])
    points, layers = np.column_stack([x, y, z]), 4
    layer = np.repeat(np.arange(layers), len(points))
    made = Scan.from_points(0.08 * index, np.tile(points, (layers, 1)), layer=layer, echo_pulse_width=1.0)
    return Scan(
        made.time, made.ego_pose_odom, made.points_ego, made.time_offset, made.unit, made.layer, made.echo,
        made.echo_pulse_width, made.flags, sweep_limits(beams), beams.units.origin_ego[:, :2].copy(),
    )  # fmt: skip

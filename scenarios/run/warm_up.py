"""Warm-up before the time measurement starts: a frame with one car, and the report of compilations."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numba.core import event

from luxloop.sim.source import StartReport, StartStatus
from luxloop.sim.world import Actors, Ego, Kind, WorldFrame

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

"""Largest acceleration and jerk in all environments of highway-env, by the drivers."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np

from luxloop.scenarios.grading.truth_events.bodies import Bodies, MotionHistory
from luxloop.scenarios.grading.truth_events.truth_event import ACCELERATION_MPS2, JERK_MPS3
from luxloop.sim.highway.environment import environments
from luxloop.sim.highway.highway_config import MOTORIST, HighwayTraffic
from luxloop.sim.highway.highway_source import HighwaySource
from luxloop.sim.source import TrafficEndedError, TrafficInputError

RANGE_M, DURATION_S = 200.0, 20.0
SEEDS = {None: (1,), MOTORIST: (1, 11, 12)}
"""Seeds by the drivers; those of highway-env exceed the limits in the first already."""


def frames(env: str, drivers: str | None, seed: int) -> Iterator[Bodies]:
    """Yield the bodies of a run, until the ego crashes."""
    config = {"other_vehicles_type": drivers} if drivers else {}
    with closing(HighwaySource(HighwayTraffic(env=env, config=config), Path(), RANGE_M)) as source:
        source.reset(seed)
        for _ in range(round(DURATION_S / source.dt)):
            try:
                yield Bodies.of(source.step())
            except TrafficEndedError:
                return


def largest(env: str, drivers: str | None) -> tuple[float, float, float]:
    """Return the largest acceleration [m/s^2] and jerk [m/s^3] over the seeds, and the shortest run [s]."""
    peaks, shortest = np.zeros(2), DURATION_S
    for seed in SEEDS[drivers]:
        history, time = MotionHistory(), 0.0
        for bodies in frames(env, drivers, seed):
            peaks, time = np.maximum(peaks, history.add(bodies).quantities[:, :2].max(axis=0)), bodies.time
        shortest = min(shortest, time)
    return float(peaks[0]), float(peaks[1]), shortest


def row(env: str) -> str:
    """Return a row of the table; values beyond the limits are bold."""
    cells = []
    for drivers in (None, MOTORIST):
        try:
            acceleration, jerk, time = largest(env, drivers)
        except TrafficInputError:  # the environment has no other vehicles to choose drivers for
            cells += ["", "", ""]
            continue
        for value, limit in ((acceleration, ACCELERATION_MPS2), (jerk, JERK_MPS3)):
            cells.append(f"**{value:.1f}**" if value > limit else f"{value:.1f}")
        cells.append(f"{time:.1f}")
    return f"| `{env}` | {' | '.join(cells)} |"


def table(_name: str) -> str:
    """Return a row for each environment."""
    head = [
        "| environment | highway-env's drivers: acceleration | jerk | time [s] "
        "| `Motorist`: acceleration | jerk | time [s] |",
        "|---|---|---|---|---|---|---|",
    ]
    return "\n".join([*head, *map(row, environments())])

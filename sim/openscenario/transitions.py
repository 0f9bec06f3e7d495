"""Courses of speed changes and lane changes (ASAM OpenSCENARIO XML 1.2, DynamicsShape and DynamicsDimension)."""

import math
from collections.abc import Callable

from luxloop import elementary
from luxloop.sim.openscenario.storyboard import Dynamics

SHAPES: dict[str, Callable[[float], float]] = {
    "step": lambda _: 1.0,
    "linear": lambda x: x,
    "cubic": lambda x: x * x * (3 - 2 * x),
    "sinusoidal": lambda x: (1 - elementary.cos(math.pi * x)) / 2,
}
"""Share of a change by share of its duration, both from 0 to 1."""
PEAKS = {"step": 0.0, "linear": 1.0, "cubic": 1.5, "sinusoidal": math.pi / 2}
"""Largest slope of each shape. A `rate` is the largest rate of the change."""


def share(dynamics: Dynamics, progress: float) -> float:
    """Return the share of a change at a progress, which may exceed 1."""
    return 1.0 if progress >= 1 else SHAPES[dynamics.shape](max(progress, 0.0))


def speed_duration(dynamics: Dynamics, before: float, after: float) -> float:
    """Return the duration [s] of a change from one speed [m/s] to another.

    Over a distance, all shapes have the mean of both speeds.
    """
    if dynamics.shape == "step":
        return 0.0
    if dynamics.dimension == "time":
        return dynamics.value
    if dynamics.dimension == "distance":
        return 2 * dynamics.value / (before + after) if before + after > 0 else 0.0
    return PEAKS[dynamics.shape] * abs(after - before) / dynamics.value


def lane_change_extent(dynamics: Dynamics, width: float) -> tuple[float, float]:
    """Return duration [s] and length [m] of a lane change over a width [m]; the unspecified one is infinite."""
    if dynamics.dimension == "distance":
        return math.inf, dynamics.value
    if dynamics.dimension == "time":
        return dynamics.value, math.inf
    return PEAKS[dynamics.shape] * abs(width) / dynamics.value, math.inf

"""Computation time of each stage, frame by frame."""

import time
from collections import defaultdict
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numpy as np

from luxloop.scenarios.metrics.definitions import DEFINITIONS, TIMED_STAGES
from luxloop.scenarios.result import Metric

Arguments = ParamSpec("Arguments")
Value = TypeVar("Value")

RECORDING = "recording"
SCANNED = "scanned"
"""Wait for traffic and sensor: their time, or less if they run ahead."""


class Stopwatch:
    """Timer of the stages of a loop by name, and of the loop from its first stage to its last."""

    def __init__(self) -> None:
        self._stage_s: dict[str, list[float]] = defaultdict(list)
        self._begin_s: float | None = None
        self._end_s = 0.0

    def time(
        self, stage: str, call: Callable[Arguments, Value], *args: Arguments.args, **kwargs: Arguments.kwargs
    ) -> Value:
        """Call a function, record its duration and return its value; a call that raises is not counted."""
        begin = time.perf_counter()
        if self._begin_s is None:
            self._begin_s = begin
        value = call(*args, **kwargs)
        self._end_s = time.perf_counter()
        self._stage_s[stage].append(self._end_s - begin)
        return value

    def add(self, stage: str, taken_s: float) -> None:
        """Record a duration that was measured elsewhere [s]."""
        self._stage_s[stage].append(taken_s)

    def stage(self, stage: str) -> dict[str, Metric]:
        """Return `perf.*` of one stage [ms]."""
        taken_s = self._stage_s[stage]
        values = {
            f"perf.{stage}_ms_p{quantile}": 1e3 * float(np.percentile(taken_s, quantile)) for quantile in (50, 99)
        }
        return {name: Metric(value, DEFINITIONS[name].unit, len(taken_s)) for name, value in values.items()}

    def metrics(self, frames: int, dt: float) -> dict[str, Metric]:
        """Return `perf.*` of a loop over `frames` frames that are `dt` apart [s].

        The real-time factor covers the whole loop, including grading and hashing, without recording.
        """
        stages = {name: metric for stage in TIMED_STAGES for name, metric in self.stage(stage).items()}
        loop_s = self._end_s - (self._begin_s or 0.0) - sum(self._stage_s[RECORDING])
        factor = "perf.realtime_factor"
        return {**stages, factor: Metric(frames * dt / loop_s, DEFINITIONS[factor].unit, frames)}

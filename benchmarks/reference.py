"""Fixed workloads that measure the machine, so that times of different machines and days can be compared."""

import time
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numba import njit

Floats = npt.NDArray[np.float64]

SIZE = 100_000
REPEATS = 15


def reference_ms() -> float:
    """Return the geometric mean of the times of both workloads [ms], each the least of several runs."""
    values = np.random.default_rng(1).random(SIZE)
    return float(np.sqrt(_least_ms(lambda: _sort_and_sum(values)) * _least_ms(lambda: _walk(values))))


def _sort_and_sum(values: Floats) -> float:
    """Sort, index and reduce with numpy."""
    order = np.argsort(values, kind="stable")
    return float(np.cumsum(np.sqrt(values[order]))[-1])


@njit(cache=True)
def _walk(values: Floats) -> float:
    """Follow a chain of divisions, roots and branches in compiled code."""
    x, total = 0.5, 0.0
    for value in values:
        x = (x + value) / (1.0 + x * value)
        total += x**0.5 if x > value else value
    return total


def _least_ms(run: Callable[[], float]) -> float:
    run()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)

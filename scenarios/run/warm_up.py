"""Warm-up before the time measurement starts: imports of the first step, and numba kernels by calling them once."""

import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from luxloop.scenarios.run.guard import Guard
from luxloop.scenarios.run.scan_source import ScannedFrame
from luxloop.tracker.tracking.filters import FilterConfig, motion


@contextmanager
def imports_beside(filters: FilterConfig, dt: float) -> Iterator[None]:
    """Import filterpy and scipy.stats, for filters and grading, while the body waits for the process of the traffic.

    Parameters
    ----------
    filters
        Filters of the tracker.
    dt
        Time between frames [s].
    """
    importing = threading.Thread(target=motion, args=(dt, filters), daemon=True)
    importing.start()
    try:
        yield
    finally:
        importing.join()  # a tracker that forks gets no import that never ends


def warm_up(scans: Iterable[ScannedFrame], unused: Guard) -> None:
    """Run a tracker that is not used again on the scans of one car (`luxloop.scenarios.run.scan_source.ScanStart`)."""
    for item in scans:
        unused.show_truth(item.frame, item.truth)
        unused.checked(unused.step(item.scan), item.scan)

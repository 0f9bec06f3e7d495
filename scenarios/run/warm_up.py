"""Warm-up of a tracker: compile its numba kernels, by calling them once, before the time measurement starts."""

from collections.abc import Iterable

from scenarios.run.guard import Guard
from scenarios.run.scan_source import ScannedFrame


def warm_up(scans: Iterable[ScannedFrame], unused: Guard) -> None:
    """Run a tracker that is not used again on the scans of one car (`scenarios.run.scan_source.ScanStart`)."""
    for item in scans:
        unused.show_truth(item.frame, item.truth)
        unused.checked(unused.step(item.scan), item.scan)

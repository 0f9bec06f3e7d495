"""Rarer garbage collection for processes of luxloop."""

import atexit
import gc

YOUNG = 200_000
"""New objects before a collection; Python's 700 make it a tenth of the time of imports, compilation and short runs.

With 50 000, collections take 0.3 s of a run of one second.
"""


def collect_rarely() -> None:
    """Let this process collect reference cycles rarely: libraries keep a million objects, frames leave few cycles."""
    gc.set_threshold(YOUNG)
    atexit.register(gc.freeze)  # Python's collection at the end takes 0.7 s with numba and pandas

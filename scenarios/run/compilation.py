"""Report of the compilation of numba kernels, which is silent and takes minutes once."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

from luxloop.sim.source import StartReport, StartStatus

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

"""The shipped tracker with a kernel that each instance compiles in its first step, as without a cache."""

from numba import njit

from luxloop.tracker.tracker import Tracker

SPEC = f"{__name__}:Compiling"


class Compiling(Tracker):
    def __init__(self, config):
        super().__init__(config)
        self.kernel = njit(lambda x: x + 1)

    def step(self, scan):
        self.kernel(1.0)
        return super().step(scan)

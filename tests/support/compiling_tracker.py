"""The shipped tracker with a kernel that each instance compiles in its first step, as without a cache."""

from numba import njit

from luxloop.scenarios.run import device
from luxloop.tracker.tracker import Tracker

SPEC = "compiling"
"""Its name; a tracker by module would compile in a process of its own."""


class Compiling(Tracker):
    def __init__(self, config):
        super().__init__(config)
        self.kernel = njit(lambda x: x + 1)

    def step(self, scan):
        self.kernel(1.0)
        return super().step(scan)


device.TRACKERS.core[SPEC] = Compiling

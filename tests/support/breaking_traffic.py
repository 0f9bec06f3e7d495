"""Scripted traffic that ends with an error, also in a process of its own."""

from luxloop.sim.scripted.scripted_source import ScriptedSource


class BreakingTraffic(ScriptedSource):
    """Raise `error` in place of the frame of that number."""

    def __init__(self, frame, error, *arguments):
        super().__init__(*arguments)
        self._left, self._error = frame, error

    def step(self):
        if self._left == 0:
            raise self._error
        self._left -= 1
        return super().step()

"""Scripted traffic that ends with an error, also in a process of its own."""

from functools import partial

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


def break_at(frame, error, monkeypatch):
    """End scripted traffic with an error at a frame."""
    monkeypatch.setattr("luxloop.sim.scripted.scripted_source.ScriptedSource", partial(BreakingTraffic, frame, error))

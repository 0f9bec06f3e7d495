"""Progress of one run and of many on standard error: bars in a terminal, in logs a line about each long silence.

The package that draws the bars is imported only in a terminal.
"""

import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

from luxloop.printable import is_terminal, print_text
from luxloop.sim.source import StartReport, StartStatus, ignore_status

_Item = TypeVar("_Item")

SILENCE_S = 5.0
"""Time after which a log names what a start waits for [s]."""

_hidden: ContextVar[bool] = ContextVar("_hidden", default=False)


@contextmanager
def hidden(wanted: bool = True) -> Iterator[None]:
    """Show no progress inside this context, as for `--quiet`."""
    token = _hidden.set(wanted)
    try:
        yield
    finally:
        _hidden.reset(token)


class _Lines:
    """Names what a start waits for on plain lines of standard error, where no terminal shows a bar.

    Parameters
    ----------
    name
        Name of the run.
    """

    def __init__(self, name: str) -> None:
        self._name, self._activity = name, ""
        self._timer: threading.Timer | None = None

    def report(self, status: StartStatus) -> None:
        """Print the activity once if it is still the same after `SILENCE_S`."""
        if status.activity != self._activity:
            self.stop()
            self._activity = status.activity
            self._timer = threading.Timer(SILENCE_S, _print_line, (f"luxloop: {self._name}: {status.activity}",))
            self._timer.daemon = True
            self._timer.start()

    def stop(self) -> None:
        """End the activity."""
        if self._timer:
            self._timer.cancel()
            self._timer.join()


def _print_line(line: str) -> None:
    print_text(line, file=sys.stderr, flush=True)


@contextmanager
def start(name: str) -> Iterator[StartReport]:
    """Show the progress of a source until frame 0, in a log what takes long. Yields the function for its reports."""
    if not _wanted():
        yield ignore_status
    elif is_terminal(sys.stderr):
        from luxloop.scenarios.run import progress_bars

        with progress_bars.of_start(name) as report:
            yield report
    else:
        lines = _Lines(name)
        try:
            yield lines.report
        finally:
            lines.stop()


def _wanted() -> bool:
    """Return False for a run in a thread, as on a worker of a sweep: the sweep shows a bar."""
    return not _hidden.get() and threading.current_thread() is threading.main_thread()


def frames(count: int, dt: float, name: str) -> Iterator[int]:
    """Yield 0 to `count` - 1 and show the progress; frames are `dt` [s] apart."""
    if not (_wanted() and is_terminal(sys.stderr)):
        yield from range(count)
        return
    from luxloop.scenarios.run import progress_bars

    with progress_bars.of_frames(dt) as bar:
        yield from bar.track(range(count), total=count, description=name)


def steps(name: str, count: int | None, what: str, items: Iterable[_Item]) -> Iterator[_Item]:
    """Yield `items` and show the progress; `count` of `what`, or None for an unknown number."""
    if _hidden.get() or not is_terminal(sys.stderr):
        yield from items
        return
    from luxloop.scenarios.run import progress_bars

    with progress_bars.of_steps(what) as bar:
        yield from bar.track(items, total=count, description=name)


@contextmanager
def runs(name: str, count: int, done: int = 0) -> Iterator[Callable[[int], None]]:
    """Show how many of `count` runs are done, and the estimated remaining time.

    Yields a function that takes the number of newly finished runs.
    """
    if _hidden.get() or not is_terminal(sys.stderr):
        yield lambda _: None
        return
    from luxloop.scenarios.run import progress_bars

    with progress_bars.of_steps("runs") as bar:
        task = bar.add_task(name, total=count, completed=done)
        yield lambda more: bar.advance(task, more)

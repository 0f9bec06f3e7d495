"""Progress bars, of a run and of many: on standard error, and only where that is a terminal."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text


class _RealTimeFactor(ProgressColumn):
    """Simulated over elapsed time of the last frames."""

    def __init__(self, dt: float) -> None:
        super().__init__()
        self._dt = dt

    def render(self, task: Task) -> Text:
        return Text("" if task.speed is None else f"{task.speed * self._dt:.1f} x real time")


def frames(count: int, dt: float, name: str) -> Iterator[int]:
    """Yield 0 to `count` - 1 and show how far it has come; frames are `dt` [s] apart.

    A run in a thread, as on a sweep's worker, shows nothing: whoever started it has a bar of his own.
    """
    console = Console(stderr=True)
    shown = console.is_terminal and threading.current_thread() is threading.main_thread()
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("frames"),
        _RealTimeFactor(dt), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=not shown) as bar:
        yield from bar.track(range(count), total=count, description=name)


@contextmanager
def runs(name: str, count: int, done: int = 0) -> Iterator[Callable[[int], None]]:
    """Show how many of `count` runs are done, and for how long the others will still take.

    Gives a function that takes how many more are.
    """
    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("runs"),
        TimeElapsedColumn(), TextColumn("still"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(name, total=count, completed=done)
        yield lambda more: bar.advance(task, more)

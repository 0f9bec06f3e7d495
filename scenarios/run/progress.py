"""Progress bars of one run and of many, on standard error and only in a terminal."""

import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

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

_Item = TypeVar("_Item")

_hidden: ContextVar[bool] = ContextVar("_hidden", default=False)


@contextmanager
def hidden(wanted: bool = True) -> Iterator[None]:
    """Show no progress inside this context, as for `--quiet`."""
    token = _hidden.set(wanted)
    try:
        yield
    finally:
        _hidden.reset(token)


class _RealTimeFactor(ProgressColumn):
    """Ratio of simulated to elapsed time over the last frames."""

    def __init__(self, dt: float) -> None:
        super().__init__()
        self._dt = dt

    def render(self, task: Task) -> Text:
        return Text("" if task.speed is None else f"{task.speed * self._dt:.1f} x real time")


def frames(count: int, dt: float, name: str) -> Iterator[int]:
    """Yield 0 to `count` - 1 and show the progress; frames are `dt` [s] apart.

    A run in a thread, as on a worker of a sweep, shows no bar: the sweep shows one.
    """
    console = Console(stderr=True)
    shown = console.is_terminal and not _hidden.get() and threading.current_thread() is threading.main_thread()
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TextColumn("frames"),
        _RealTimeFactor(dt), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=not shown) as bar:
        yield from bar.track(range(count), total=count, description=name)


def steps(name: str, count: int | None, what: str, items: Iterable[_Item]) -> Iterator[_Item]:
    """Yield `items` and show the progress; `count` of `what`, or None for an unknown number."""
    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TextColumn(what),
        TimeElapsedColumn(), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=_hidden.get() or not console.is_terminal) as bar:
        yield from bar.track(items, total=count, description=name)


@contextmanager
def runs(name: str, count: int, done: int = 0) -> Iterator[Callable[[int], None]]:
    """Show how many of `count` runs are done, and the estimated remaining time.

    Yields a function that takes the number of newly finished runs.
    """
    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TextColumn("runs"),
        TimeElapsedColumn(), TextColumn("remaining"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=_hidden.get() or not console.is_terminal) as bar:
        task = bar.add_task(name, total=count, completed=done)
        yield lambda more: bar.advance(task, more)

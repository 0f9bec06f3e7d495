"""The progress bar of a run: on standard error, and only where that is a terminal."""

import threading
from collections.abc import Iterator

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
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

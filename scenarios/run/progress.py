"""Progress bars of one run and of many, on standard error and only in a terminal."""

import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
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
from rich.progress_bar import ProgressBar
from rich.text import Text

from luxloop.sim.source import StartReport, StartStatus

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


class _StartColumn(ProgressColumn):
    """Bar of a start: its share or the position in the file that is read, else a pulse."""

    def render(self, task: Task) -> ProgressBar:
        status: StartStatus | None = task.fields["status"]
        share = status and (status.share if status.share is not None else _share_read(status))
        return ProgressBar(1.0, share or 0.0, width=40, pulse=share is None, animation_time=task.elapsed)


def _share_read(status: StartStatus) -> float | None:
    """Return the share of a file that a process has read, by its open descriptors; None where the system has none."""
    folder = Path("/proc", "self" if status.process is None else str(status.process))
    try:
        for link in (folder / "fd").iterdir():
            with suppress(OSError):  # closed meanwhile
                if str(link.readlink()) == status.file:
                    position = int((folder / "fdinfo" / link.name).read_text().split()[1])
                    return position / max(Path(status.file).stat().st_size, 1)
    except OSError:
        pass
    return None


@contextmanager
def start(name: str) -> Iterator[StartReport]:
    """Show the progress of a source until frame 0. Yields the function that takes its reports."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}", markup=False), _StartColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not _shown(console)) as bar:
        task = bar.add_task(name, total=None, status=None)
        yield lambda status: bar.update(task, description=f"{name}: {status.activity}", status=status)


def _shown(console: Console) -> bool:
    """Return False for a run in a thread, as on a worker of a sweep: the sweep shows a bar."""
    return console.is_terminal and not _hidden.get() and threading.current_thread() is threading.main_thread()


def frames(count: int, dt: float, name: str) -> Iterator[int]:
    """Yield 0 to `count` - 1 and show the progress; frames are `dt` [s] apart."""
    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TextColumn("frames"),
        _RealTimeFactor(dt), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=not _shown(console)) as bar:
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

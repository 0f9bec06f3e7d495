"""Progress of one run and of many on standard error: bars in a terminal, in logs a line about each long silence."""

import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import TypeVar

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

from luxloop.console import PrintableConsole
from luxloop.printable import print_text
from luxloop.sim.source import StartReport, StartStatus

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
    console = PrintableConsole(stderr=True)
    if not console.is_terminal and _wanted():
        lines = _Lines(name)
        try:
            yield lines.report
        finally:
            lines.stop()
        return
    columns = (TextColumn("{task.description}", markup=False), _StartColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not _shown(console)) as bar:
        task = bar.add_task(name, total=None, status=None)
        yield lambda status: bar.update(task, description=f"{name}: {status.activity}", status=status)


def _shown(console: PrintableConsole) -> bool:
    """Return True if a bar is wanted and can be shown."""
    return console.is_terminal and _wanted()


def _wanted() -> bool:
    """Return False for a run in a thread, as on a worker of a sweep: the sweep shows a bar."""
    return not _hidden.get() and threading.current_thread() is threading.main_thread()


def frames(count: int, dt: float, name: str) -> Iterator[int]:
    """Yield 0 to `count` - 1 and show the progress; frames are `dt` [s] apart."""
    console = PrintableConsole(stderr=True)
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TextColumn("frames"),
        _RealTimeFactor(dt), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=not _shown(console)) as bar:
        yield from bar.track(range(count), total=count, description=name)


def steps(name: str, count: int | None, what: str, items: Iterable[_Item]) -> Iterator[_Item]:
    """Yield `items` and show the progress; `count` of `what`, or None for an unknown number."""
    console = PrintableConsole(stderr=True)
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
    console = PrintableConsole(stderr=True)
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TextColumn("runs"),
        TimeElapsedColumn(), TextColumn("remaining"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=_hidden.get() or not console.is_terminal) as bar:
        task = bar.add_task(name, total=count, completed=done)
        yield lambda more: bar.advance(task, more)

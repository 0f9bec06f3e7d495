"""Bars of the progress in a terminal, by rich."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

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
from luxloop.sim.source import StartReport, StartStatus


@contextmanager
def of_start(name: str) -> Iterator[StartReport]:
    """Show what a start waits for, and yield the function for its reports."""
    with _bar(_StartColumn(), TimeElapsedColumn()) as bar:
        task = bar.add_task(name, total=None, status=None)
        yield lambda status: bar.update(task, description=f"{name}: {status.activity}", status=status)


def of_frames(dt: float) -> Progress:
    """Return the bar of a run whose frames are `dt` [s] apart."""
    counted = (BarColumn(), MofNCompleteColumn(), TextColumn("frames"))
    return _bar(*counted, _RealTimeFactor(dt), TimeRemainingColumn())


def of_steps(what: str) -> Progress:
    """Return the bar of counted steps; `what` is their plural."""
    counted = (BarColumn(), MofNCompleteColumn(), TextColumn(what))
    return _bar(*counted, TimeElapsedColumn(), TextColumn("remaining"), TimeRemainingColumn())


def _bar(*columns: ProgressColumn) -> Progress:
    named = TextColumn("{task.description}", markup=False)
    return Progress(named, *columns, console=PrintableConsole(stderr=True), transient=True)


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

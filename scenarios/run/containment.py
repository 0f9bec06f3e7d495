"""Isolation and time limit of an in-process tracker, as far as one process allows.

- Standard output belongs to the result (`--json`): what a tracker prints goes to standard error.
- `os._exit` and `os.exec*` raise SystemExit, like `sys.exit`, so that a tracker cannot set the exit code.
- A forked copy of the run ends when it leaves the tracker.
- Warning filters, numpy's error state and the current folder are those of the harness again after each call.

Code in the same process can still read and change any object of the harness, end the process by a signal, or crash it.
A tracker in its own process cannot, see `luxloop.scenarios.run.process_tracker`.

The time limit is that of the process's alarm clock (`signal.setitimer`): it interrupts Python code and waiting in the
main thread. Compiled code that does not return cannot be interrupted; a tracker in its own process can.
"""

import mmap
import os
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from types import FrameType
from typing import Any

import numpy as np

from luxloop.scenarios.run.termination import SIGNALS, in_main_thread

STEP_TIMEOUT_S = 60.0
"""Default limit of one step of a tracker [s]."""
START_FACTOR = 10
"""The warm-up and the start of a tracker may take this many times the limit of a step: they compile kernels."""
REPEAT_S = 0.5
"""Interval after which a tracker that ignored the timeout is interrupted again [s]."""
PATIENCE = 6
"""Number of interrupts after which the process ends."""
EXIT_CODE = 4

_end_process = os._exit
"""Bound on import: `contained` replaces `os._exit` while a tracker is in use."""


class StepTimeoutError(BaseException):
    """A call took longer than its limit. A BaseException, because trackers catch `Exception`."""


@dataclass
class Watch:
    """Signals received during a call."""

    alarms: int = 0
    interrupted: bool = False
    """True after Ctrl-C or a like signal, even if the tracker caught the KeyboardInterrupt."""


@contextmanager
def watched(limit_s: float, last_words: str) -> Iterator[Watch]:
    """Raise a `StepTimeoutError` in the body after `limit_s`; no limit applies outside the main thread.

    A body that ignores `PATIENCE` interrupts ends the process with `EXIT_CODE`, after `last_words` on standard error.
    """
    watch = Watch()
    if not (in_main_thread() and hasattr(signal, "setitimer")):
        yield watch
        return

    def on_alarm(_signal: int, _frame: FrameType | None) -> None:
        watch.alarms += 1
        if watch.alarms > PATIENCE:
            os.write(2, f"luxloop: error: {last_words}\n".encode())
            _end_process(EXIT_CODE)
        raise StepTimeoutError

    def on_interrupt(number: int, frame: FrameType | None) -> None:
        watch.interrupted = True
        if callable(handler := earlier_interrupt[number]):
            handler(number, frame)

    earlier_alarm = signal.signal(signal.SIGALRM, on_alarm)
    handled = [number for number in SIGNALS if callable(signal.getsignal(number))]
    earlier_interrupt = {number: signal.signal(number, on_interrupt) for number in handled}
    earlier_timer = signal.setitimer(signal.ITIMER_REAL, limit_s, REPEAT_S)
    try:
        yield watch
    finally:
        signal.setitimer(signal.ITIMER_REAL, *earlier_timer)
        signal.signal(signal.SIGALRM, earlier_alarm or signal.SIG_DFL)
        for number, handler in earlier_interrupt.items():
            signal.signal(number, handler)


_EXITS = ("_exit", "abort", "execv", "execve")
"""Functions of `os` that end a process or replace its program; all of `os.exec*` call the last two."""
_OUTPUTS = (1, 2)
"""File descriptors of standard output and standard error."""


class _Unclosable:
    """A text stream that a tracker can write to, but not close."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def close(self) -> None:
        """Flush only."""
        self._stream.flush()


@contextmanager
def contained() -> Iterator[None]:
    """Redirect standard output to standard error and disable functions that end the process, in the main thread."""
    if not in_main_thread():  # workers of a sweep, whose threads share the process
        yield
        return
    with ExitStack() as stack:
        stack.enter_context(_descriptors_redirected())
        stack.callback(setattr, sys, "stdout", sys.stdout)
        stack.callback(setattr, sys, "stderr", sys.stderr)
        stream: Any = _Unclosable(sys.stderr)
        sys.stdout = sys.stderr = stream
        for name in _EXITS:
            stack.callback(setattr, os, name, getattr(os, name))
            setattr(os, name, _refusal(name, getattr(os, name), os.getpid()))
        yield


@contextmanager
def call_restored() -> Iterator[None]:
    """Restore warning filters and numpy's error state after a call."""
    filters = warnings.filters[:]
    with np.errstate():
        try:
            yield
        finally:
            if warnings.filters != filters:
                warnings.filters[:] = filters  # type: ignore[index]


@contextmanager
def _descriptors_redirected() -> Iterator[None]:
    """Redirect file descriptor 1 to 2, for compiled code that prints; restore both at the end."""
    saved: dict[int, int] = {}
    sys.stdout.flush()
    with suppress(OSError):  # closed by the caller: nothing can be printed there
        saved = {number: os.dup(number) for number in _OUTPUTS}
        os.dup2(2, 1)
    try:
        yield
    finally:
        for number, copy in saved.items():
            os.dup2(copy, number)
            os.close(copy)


def _refusal(name: str, original: Any, harness: int) -> Any:
    """Return a function that raises SystemExit in the process of the harness, and works as usual in its children."""

    def refuse(*arguments: Any, **named: Any) -> None:
        if os.getpid() != harness:
            original(*arguments, **named)
        raise SystemExit(f"os.{name}({', '.join(map(repr, arguments))})")

    return refuse


class ForkMark:
    """Detects that a forked copy of the run came back from a tracker; the copy shares one byte with the run."""

    def __init__(self) -> None:
        self._process = os.getpid()
        self._mark = mmap.mmap(-1, 1)

    @property
    def set(self) -> bool:
        """True if a copy came back."""
        return self._mark[0] != 0

    def leave_if_copy(self) -> None:
        """End this process if it is a copy."""
        if os.getpid() != self._process:
            self._mark[0] = 1
            _end_process(EXIT_CODE)

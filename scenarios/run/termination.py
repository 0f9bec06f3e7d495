"""Ctrl-C, SIGTERM and SIGHUP: temporary files are removed, and one line states what is kept."""

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import resource_tracker
from types import FrameType
from typing import Any

CTRL_C = 130
"""Exit code of Ctrl-C: 128 and the number of SIGINT."""
SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
SAME_S = 1.0
"""[s] A further SIGTERM or SIGHUP within this time belongs to the first: a terminal that closes sends two."""
LATER_S = 0.05
"""[s] An interrupt inside `UNINTERRUPTIBLE` frames is tried again after this time."""


@dataclass
class Received:
    """The last of these signals that arrived."""

    number: int = 0
    """Number of the signal, 0 if none arrived."""
    at_s: float = -SAME_S
    """Time of its arrival on the monotonic clock [s]."""
    waits: bool = False
    """It waits for the end of `UNINTERRUPTIBLE` frames; a timer looks again."""

    def stop_waiting(self) -> None:
        """Stop the timer of a signal that waits."""
        if self.waits:
            self.waits = False
            signal.setitimer(signal.ITIMER_REAL, 0.0)

    @property
    def exit_code(self) -> int:
        """Exit code of the interrupted command: 143 for SIGTERM, 129 for SIGHUP, 130 for Ctrl-C."""
        return 128 + self.number if self.number else CTRL_C


Handler = Callable[[int, FrameType | None], Any] | int | None
"""What `signal.signal` takes and returns."""
UNINTERRUPTIBLE = ("<frozen importlib._bootstrap>", f"{os.sep}llvmlite{os.sep}")
"""Parts of the file names of frames that must end: CPython's import of a module, and llvmlite, which frees a module of
LLVM twice if it is interrupted while another object becomes its owner."""
_handled: list[Received] = []
"""Signals of the active `as_interrupts` contexts, the innermost last."""


def in_main_thread() -> bool:
    """Return True in the only thread that receives signals."""
    return threading.current_thread() is threading.main_thread()


def start_resource_tracker() -> None:
    """Start the process in which Python tracks shared resources, with SIGHUP blocked.

    A terminal sends SIGHUP to all its processes. Python starts a tracker that died again, and that one prints a
    traceback for each lock that it does not know.
    """
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGHUP})  # the process inherits it
    try:
        resource_tracker.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGHUP})


@contextmanager
def as_interrupts() -> Iterator[Received]:
    """Raise a KeyboardInterrupt in the body for all of these signals that are not ignored, as `nohup` does.

    One that arrives inside an import, or inside llvmlite, is raised after it: they may crash the process otherwise, or
    keep a lock. One that arrives in a destructor is lost without a report; `raise_lost` raises it again.
    """
    received = Received()
    earlier: dict[int, Handler] = {}

    def interrupt(number: int, frame: FrameType | None) -> None:
        same = time.monotonic() - received.at_s < SAME_S
        received.number, received.at_s = number, time.monotonic()
        if not same or number == signal.SIGINT:
            raise_or_wait(number, frame)

    def raise_or_wait(_number: int, frame: FrameType | None) -> None:
        if _must_end(frame):
            earlier.setdefault(signal.SIGALRM, signal.signal(signal.SIGALRM, raise_or_wait))
            received.waits = True
            signal.setitimer(signal.ITIMER_REAL, LATER_S)
        else:
            received.stop_waiting()
            raise KeyboardInterrupt

    used = [number for number in SIGNALS if in_main_thread() and signal.getsignal(number) is not signal.SIG_IGN]
    earlier |= {number: signal.signal(number, interrupt) for number in used}
    report_unraisable = sys.unraisablehook
    if used:  # of the whole process
        sys.unraisablehook = _except_interrupts(report_unraisable)
    _handled.append(received)
    try:
        yield received
    finally:
        _handled.pop()
        if used:
            sys.unraisablehook = report_unraisable
        received.stop_waiting()
        for number, handler in earlier.items():
            signal.signal(number, handler or signal.SIG_DFL)


def _must_end(frame: FrameType | None) -> bool:
    """Return True if this frame or one of its callers is of `UNINTERRUPTIBLE` code."""
    while frame and not any(part in frame.f_code.co_filename for part in UNINTERRUPTIBLE):
        frame = frame.f_back
    return frame is not None


def end_at_once(code: int) -> None:
    """End the process with this exit code at the next of these signals: its command has ended, only Python has not."""
    for number in SIGNALS:
        if in_main_thread() and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda *_: os._exit(code))


def _except_interrupts(
    report: Callable[["sys.UnraisableHookArgs"], object],
) -> Callable[["sys.UnraisableHookArgs"], None]:
    """Return a hook for errors that Python cannot raise, which reports all but interrupts."""

    def hook(unraisable: "sys.UnraisableHookArgs") -> None:
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            report(unraisable)

    return hook


def raise_lost() -> None:
    """Raise a KeyboardInterrupt again that was lost inside an `as_interrupts` context.

    Numpy drops every error of an attribute that it looks up, and with Python 3.11 the lookup on a member of an
    enumeration is Python code, in which a signal may arrive. Python drops every error of a destructor.
    """
    if any(received.number for received in _handled):
        for received in _handled:
            received.stop_waiting()
        raise KeyboardInterrupt


def is_interrupt(error: BaseException) -> bool:
    """Return True for a KeyboardInterrupt, and for the SystemError that numba makes of one while it loads a kernel."""
    if isinstance(error, SystemError) and error.__cause__:
        return is_interrupt(error.__cause__)
    return isinstance(error, KeyboardInterrupt)


def clear_unhandled() -> None:
    """Clear CPython's record of a KeyboardInterrupt that left a string given to `exec`, as inside `dataclass`.

    With `python -m` CPython ends such a process by SIGINT at its exit, also when the interrupt was caught further out
    and an exit code was set (`_Py_UnhandledKeyboardInterrupt` of pythonrun.c).
    """
    exec("")

"""Time limit of a call into a tracker, and its distinction from Ctrl-C and from exceptions of the tracker.

The limit is that of the process's alarm clock (`signal.setitimer`): it interrupts Python code and waiting in the main
thread. Compiled code that does not return cannot be interrupted; a tracker in its own process can.
"""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

STEP_TIMEOUT_S = 60.0
"""Default limit of one step of a tracker [s]."""
START_FACTOR = 10
"""The warm-up and the start of a tracker may take this many times the limit of a step: they compile kernels."""
REPEAT_S = 0.5
"""Interval after which a tracker that ignored the timeout is interrupted again [s]."""
PATIENCE = 6
"""Number of interrupts after which the process ends."""
EXIT_CODE = 4
INTERRUPTS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that end a run in order, see `luxloop.scenarios.run.termination`."""

_end_process = os._exit
"""Bound on import: `containment` replaces `os._exit` while a tracker is in use."""


class StepTimeoutError(BaseException):
    """A call took longer than its limit. A BaseException, because trackers catch `Exception`."""


@dataclass
class Watch:
    """Signals received during a call."""

    alarms: int = 0
    interrupted: bool = False
    """True after Ctrl-C or a like signal, even if the tracker caught the KeyboardInterrupt."""


def in_main_thread() -> bool:
    """Return True in the only thread that receives signals."""
    return threading.current_thread() is threading.main_thread()


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
    handled = [number for number in INTERRUPTS if callable(signal.getsignal(number))]
    earlier_interrupt = {number: signal.signal(number, on_interrupt) for number in handled}
    earlier_timer = signal.setitimer(signal.ITIMER_REAL, limit_s, REPEAT_S)
    try:
        yield watch
    finally:
        signal.setitimer(signal.ITIMER_REAL, *earlier_timer)
        signal.signal(signal.SIGALRM, earlier_alarm or signal.SIG_DFL)
        for number, handler in earlier_interrupt.items():
            signal.signal(number, handler)

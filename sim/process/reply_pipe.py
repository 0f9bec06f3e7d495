"""Pipe of the replies of a worker process, with a limit on the wait for each.

A simulator that is stopped or hangs keeps its pipe open, so that a plain read would wait for ever.
"""

import io
import os
import select
from typing import Any

PATIENCE_S = 600.0
"""[s] Longest wait for a reply or a report: the largest nets take minutes to load."""
SLICE_S = 1.0
"""[s] The wait is counted in slices, so that a run that was itself stopped (Ctrl-Z) loses one at most."""


class StoppedError(Exception):
    """The process has not replied for a long time."""


class ReplyPipe(io.RawIOBase):
    """Reading end of a pipe.

    Parameters
    ----------
    descriptor
        File descriptor of the pipe; it is not closed.
    """

    def __init__(self, descriptor: int) -> None:
        super().__init__()
        self._descriptor = descriptor
        self._poll = select.poll()
        self._poll.register(descriptor, select.POLLIN)
        self.patience_s = PATIENCE_S
        """Longest wait for bytes [s]."""

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: Any, /) -> int:
        """Read into a buffer and return the number of bytes, 0 at the end of the pipe.

        Raises
        ------
        StoppedError
            No byte arrived in time.
        """
        slices = max(1, round(self.patience_s / SLICE_S))
        wait_ms = round(1e3 * min(SLICE_S, self.patience_s))
        if not any(self._poll.poll(wait_ms) for _ in range(slices)):
            raise StoppedError
        return os.readv(self._descriptor, [buffer])

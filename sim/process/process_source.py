"""Traffic source in a worker process.

libsumo holds one simulation per process, and some inputs make its C++ code terminate the process. In a worker process,
such a crash becomes an ordinary error, and the simulator runs on another core than sensor and tracker.

The process outlives its run and serves the next one, since Python, numba and libsumo take a second to load. A
simulator that is stopped or hangs keeps its pipe open, so that the wait for each reply is limited.
`multiprocessing` would import the caller's main program in the worker, with all its imports; `subprocess` does not.
"""

import atexit
import io
import os
import pickle
import select
import shutil
import subprocess
import sys
import tempfile
import uuid
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import numpy as np

from luxloop.arrays import Floats
from luxloop.sim.process.worker import Preload, Request, StartRun, internal_error
from luxloop.sim.source import (
    EgoCommand,
    SimulatorFailedError,
    StartReport,
    StartStatus,
    TrafficEndedError,
    TrafficInputError,
    ignore_status,
)

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


IDLE_PATIENCE_S = 10.0
"""Longest wait for the reply of an idle process [s]; a new one takes its place."""
PYTHON_ERROR = 1
"""Exit code of Python after an exception that nothing caught."""
AHEAD = 4
"""Frames computed in advance: they even out steps of different duration at negligible memory."""


Start_co = TypeVar("Start_co", covariant=True)
Frame_co = TypeVar("Frame_co", covariant=True)


class SteppedSource(Protocol[Start_co, Frame_co]):
    """A source that a worker process can run: traffic, or a survey of it. See `luxloop.sim.source.TrafficSource`."""

    dt: float
    origin: Floats
    warnings: tuple[str, ...]
    ego_name: str

    def reset(self, seed: int) -> Start_co:
        """Start a new run."""
        ...

    def step(self) -> Frame_co:
        """Return the next frame."""
        ...

    def apply(self, command: EgoCommand) -> None:
        """Command the ego."""
        ...

    def close(self) -> None:
        """Release the simulator."""
        ...


class ProcessSource(Generic[Start_co, Frame_co]):
    """Adapter that runs another source in a worker process: the same frames bit for bit, and the same errors.

    Parameters
    ----------
    source
        Source to run. The worker gets a copy; this instance is never reset.
    name
        Name of the simulator in messages.
    ahead
        Frames to compute in advance; 0 for a controlled ego, so that a command is effective from the next frame on.
    patience_s
        Longest wait for a reply of the process [s]; a stopped one is ended then.
    """

    def __init__(
        self, source: SteppedSource[Start_co, Frame_co], name: str, ahead: int = AHEAD, patience_s: float = PATIENCE_S
    ):
        self.dt = source.dt
        self.origin = np.zeros(2)
        self.warnings: tuple[str, ...] = ()
        self.ego_name = ""
        self.report_start: StartReport = ignore_status
        """Receives the progress of `reset`."""
        self._source = source
        self._name = name
        self._ahead = ahead
        self._patience_s = patience_s
        self._process: _Process | None = None
        self._reusable = True
        self._next = 0

    def reset(self, seed: int) -> Start_co:
        """Start a new run. See `TrafficSource.reset`."""
        self.close()
        self._reusable, self._next = True, 0
        try:
            self._process = _Process.acquire(self._patience_s)
        except OSError as error:
            raise SimulatorFailedError(f"{self._name}: cannot start its process ({error.strerror})") from error
        start = StartRun(pickle.dumps(self._source), seed, self._ahead, str(Path.cwd()), list(map(str, sys.path)))
        try:
            started, self.origin, self.warnings, self.ego_name = self._ask(start, "at its start")
        except Exception:
            self.close()
            raise
        return started  # type: ignore[no-any-return]

    def step(self) -> Frame_co:
        """Return the next frame; wait for it if necessary. See `TrafficSource.step`."""
        frame: Frame_co = self._ask(Request.STEP, f"at {self._next * self.dt:.2f} s")
        self._next += 1
        return frame

    def apply(self, command: EgoCommand) -> None:
        """Command the ego. See `TrafficSource.apply`."""
        if self._ahead:
            raise TrafficInputError(f"{self._name} was not set up for a controlled ego: frames are computed ahead")
        self._ask(command, f"at {self._next * self.dt:.2f} s")

    def close(self) -> None:
        """End the run. Its process is kept for the next run, unless this run failed and left an unknown state."""
        process, self._process = self._process, None
        if process is None:
            return
        try:
            process.send(Request.CLOSE)
            while process.receive() is not Request.CLOSE:
                pass
        except (EOFError, StoppedError):  # it died or stopped after its last reply, so the run is not affected
            self._reusable = False
        except BaseException:
            process.terminate()
            raise
        if self._reusable:
            process.idle.append(process)
        else:
            process.terminate()

    def _ask(self, request: object, when: str) -> Any:
        """Return the reply to a request; `when` is part of the message if the process dies."""
        process = self._process
        if process is None:
            raise SimulatorFailedError(f"{self._name} is not running: call reset first")
        try:
            process.send(request)
            while isinstance(reply := process.receive(), StartStatus):
                self.report_start(replace(reply, process=process.number))
        except EOFError:
            reason, remedy = process.exit_reason()
            trace = process.python_traceback()
            self._drop(process)
            if trace:
                raise internal_error(f"{self._name}'s process ended with an error of Python {when}", trace) from None
            raise SimulatorFailedError(f"{self._name}'s process died ({reason}) {when}; {remedy}") from None
        except StoppedError:
            self._drop(process)
            raise SimulatorFailedError(
                f"{self._name}'s process gave no reply for {self._patience_s:g} s {when} and was ended; run it again, "
                "and if this repeats, try the same input in the simulator itself"
            ) from None
        except BaseException:  # such as Ctrl-C during a reply: the rest of it would be read as the next reply
            self._drop(process)
            raise
        if isinstance(reply, Exception):
            self._reusable = isinstance(reply, TrafficEndedError)
            raise reply
        return reply

    def _drop(self, process: "_Process") -> None:
        self._process = None
        process.terminate()


class _Process:
    """A Python process that runs `luxloop.sim.process.worker.serve`."""

    idle: ClassVar[list["_Process"]] = []
    """Processes without a run, kept for the next one."""

    def __init__(self) -> None:
        # The process makes the folder: only then does a parent that is killed at any time leave none.
        self._scratch = str(Path(tempfile.gettempdir(), f"luxloop-{uuid.uuid4().hex}"))
        self._owner = os.getpid()
        path = list(map(str, sys.path))
        worker = f"from luxloop.sim.process.worker import serve; serve({self._scratch!r})"
        program = f"import sys; sys.path[:] = {path!r}; {worker}"
        # messages of the simulator; a pipe that is not read would block it
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115
        self._popen = subprocess.Popen(
            [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._stderr
        )
        assert self._popen.stdin
        assert self._popen.stdout
        self._requests = self._popen.stdin
        self._pipe = ReplyPipe(self._popen.stdout.fileno())
        self._replies = io.BufferedReader(self._pipe)

    @classmethod
    def acquire(cls, patience_s: float) -> "_Process":
        """Return an idle process, or a new one, whose replies are waited for at most `patience_s`.

        Idle processes that died meanwhile are discarded. So are those inherited by a fork: `poll` reports a process
        that is not a child as dead.
        """
        while cls.idle:
            process = cls.idle.pop()
            process._pipe.patience_s = min(patience_s, IDLE_PATIENCE_S)
            if process._popen.poll() is None and process._is_alive():
                process._pipe.patience_s = patience_s
                return process
            process.terminate()
        process = cls()
        process._pipe.patience_s = patience_s
        return process

    @property
    def number(self) -> int:
        """Its number in the operating system."""
        return self._popen.pid

    def _is_alive(self) -> bool:
        """Return True if the process replies; `poll` may not report a process that was killed just now."""
        self.send(Request.PING)
        try:
            return self.receive() is Request.PING
        except (EOFError, StoppedError):
            return False

    def send(self, request: object) -> None:
        """Send a request. A dead process is detected by `receive`."""
        with suppress(OSError):
            pickle.dump(request, self._requests, protocol=5)
            self._requests.flush()

    def receive(self) -> Any:
        """Return the next reply.

        Raises
        ------
        EOFError
            The process is dead.
        StoppedError
            It has not replied for a long time.
        """
        try:
            return pickle.load(self._replies)
        except StoppedError:
            raise
        except (OSError, pickle.UnpicklingError) as error:
            raise EOFError from error

    def exit_reason(self) -> tuple[str, str]:
        """Return the reason of the process's death, and a remedy."""
        with suppress(subprocess.TimeoutExpired):  # the pipe closes shortly before the process ends
            self._popen.wait(timeout=5.0)
        code = self._popen.poll()
        if code == -9:  # SIGKILL; Windows lacks the name
            return "signal 9", "it was killed, possibly out of memory; run it again, with less traffic if necessary"
        lines = self._messages().split("\n")
        last_words = next((f"its last message: {line.strip()}; " for line in reversed(lines) if line.strip()), "")
        reason = f"signal {-code}" if code is not None and code < 0 else f"exit code {code}"
        return reason, last_words + "try the same input in the simulator itself"

    def python_traceback(self) -> str:
        """Return the traceback that ended the process, if one did: an error of luxloop, not of the simulator."""
        _, head, trace = self._messages().rpartition("Traceback (most recent call last):")
        return head + trace if head and self._popen.poll() == PYTHON_ERROR else ""

    def _messages(self) -> str:
        """Return what the process printed on standard error."""
        self._stderr.seek(0)
        return self._stderr.read().decode(errors="replace")

    def terminate(self) -> None:
        """Kill the process if it is alive, and remove its scratch folder.

        The folder is removed before, too: if this process is killed in between, neither would remove it.
        """
        self._remove_scratch()
        self._popen.kill()
        self._popen.wait()
        self._remove_scratch()
        self._replies.close()
        if self._popen.stdout:
            self._popen.stdout.close()
        self._stderr.close()
        with suppress(OSError):  # an unread request may remain in the buffer
            self._requests.close()

    def _remove_scratch(self) -> None:
        if os.getpid() == self._owner:
            shutil.rmtree(self._scratch, ignore_errors=True)


def _terminate_idle() -> None:
    while _Process.idle:
        _Process.idle.pop().terminate()


def start_early(module: str) -> None:
    """Start the process of the next run, unless there is one, and let it import a module meanwhile."""
    with suppress(OSError):  # the run reports it
        if not _Process.idle:
            _Process.idle.append(_Process())
            _Process.idle[-1].send(Preload(module))


atexit.register(_terminate_idle)

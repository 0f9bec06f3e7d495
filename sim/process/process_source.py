"""Traffic in a process of its own.

libsumo holds one simulation per process, and some inputs make its C++ end the whole process. Apart, a simulator that
dies is an error like any other, and it runs beside sensor and tracker on another core.

The process outlives its run and serves the next one, since Python, numba and libsumo take a second to load.
`multiprocessing` would import the caller's main program there, with all that it imports; this does not.
"""

import atexit
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from sim.process.worker import Order, Start
from sim.source import EgoCommand, SimulatorFailedError, TrafficEndedError, TrafficInputError, TrafficSource
from sim.world import Obstacles, WorldFrame

AHEAD = 4
"""Frames computed before they are asked for: they even out steps of different length, and are no burden on memory."""


class ApartSource:
    """Another source, run in a process of its own: the same frames bit for bit, and the same errors.

    Parameters
    ----------
    source
        What to run. A copy of it is sent over; it is never reset itself.
    name
        What messages call it.
    ahead
        Frames to compute before they are asked for; 0 for an ego that is to be commanded, so that a command acts from
        the very next frame on.
    """

    def __init__(self, source: TrafficSource, name: str, ahead: int = AHEAD):
        self.dt = source.dt
        self.origin = np.zeros(2)
        self._source = source
        self._name = name
        self._ahead = ahead
        self._process: _Process | None = None
        self._sound = True
        self._next = 0

    def reset(self, seed: int) -> Obstacles:
        """Start a new run. See `TrafficSource.reset`."""
        self.close()
        self._sound, self._next = True, 0
        try:
            self._process = _Process.hire()
        except OSError as error:
            raise SimulatorFailedError(f"{self._name}: cannot start its process ({error.strerror})") from error
        start = Start(pickle.dumps(self._source), seed, self._ahead, str(Path.cwd()), list(map(str, sys.path)))
        try:
            obstacles, self.origin = self._ask(start, "at its start")
        except Exception:
            self.close()
            raise
        return obstacles  # type: ignore[no-any-return]

    def step(self) -> WorldFrame:
        """Return the next frame, waiting for it if need be. See `TrafficSource.step`."""
        frame: WorldFrame = self._ask(Order.STEP, f"at {self._next * self.dt:.2f} s")
        self._next += 1
        return frame

    def apply(self, command: EgoCommand) -> None:
        """Command the ego. See `TrafficSource.apply`."""
        if self._ahead:
            raise TrafficInputError(f"{self._name} was not set up for a controlled ego: frames are computed ahead")
        self._ask(command, f"at {self._next * self.dt:.2f} s")

    def close(self) -> None:
        """End the run. Its process waits for another, unless this one failed: who knows what that has left behind."""
        process, self._process = self._process, None
        if process is None:
            return
        try:
            process.send(Order.CLOSE)
            while process.receive() is not Order.CLOSE:
                pass
        except EOFError:  # it died when nothing was wanted of it any more
            self._sound = False
        except BaseException:
            process.end()
            raise
        if self._sound:
            process.idle.append(process)
        else:
            process.end()

    def _ask(self, request: object, when: str) -> Any:
        """Return the reply to a request; `when` is told if the process dies over it."""
        process = self._process
        if process is None:
            raise SimulatorFailedError(f"{self._name} is not running: reset comes before all else")
        try:
            process.send(request)
            reply = process.receive()
        except EOFError:
            how, remedy = process.fate()
            self._drop(process)
            raise SimulatorFailedError(f"{self._name}'s process died ({how}) {when}; {remedy}") from None
        except BaseException:  # as Ctrl-C amid a frame: what would be read next is the rest of it
            self._drop(process)
            raise
        if isinstance(reply, Exception):
            self._sound = isinstance(reply, TrafficEndedError)
            raise reply
        return reply

    def _drop(self, process: "_Process") -> None:
        self._process = None
        process.end()


class _Process:
    """A Python process that runs `sim.process.worker.serve`."""

    idle: ClassVar[list["_Process"]] = []
    """Those that have ended their run well."""

    def __init__(self) -> None:
        self._scratch = tempfile.mkdtemp(prefix="luxloop-")
        self._owner = os.getpid()
        path = list(map(str, sys.path))
        program = f"import sys; sys.path[:] = {path!r}; from sim.process.worker import serve; serve({self._scratch!r})"
        # what a simulator complains of; a pipe that nobody reads would block it
        self._said = tempfile.TemporaryFile()  # noqa: SIM115
        self._popen = subprocess.Popen(
            [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said
        )
        assert self._popen.stdin
        assert self._popen.stdout
        self._requests, self._replies = self._popen.stdin, self._popen.stdout

    @classmethod
    def hire(cls) -> "_Process":
        """Return an idle process, or a new one.

        One that died meanwhile is passed over. So is one that a fork inherited: `poll` takes what is no child for dead.
        """
        while cls.idle:
            process = cls.idle.pop()
            if process._popen.poll() is None and process._answers():
                return process
            process.end()
        return cls()

    def _answers(self) -> bool:
        """Whether anybody is there: a process that was killed just now may not be known to be dead."""
        self.send(Order.ANSWER)
        try:
            return self.receive() is Order.ANSWER
        except EOFError:
            return False

    def send(self, request: object) -> None:
        """Send a request. Whether anybody is there to read it is found out by `receive`."""
        with suppress(OSError):
            pickle.dump(request, self._requests, protocol=5)
            self._requests.flush()

    def receive(self) -> Any:
        """Return the next reply.

        Raises
        ------
        EOFError
            The process is dead.
        """
        try:
            return pickle.load(self._replies)
        except (OSError, pickle.UnpicklingError) as error:
            raise EOFError from error

    def fate(self) -> tuple[str, str]:
        """Return how the process died, and what that suggests to do."""
        with suppress(subprocess.TimeoutExpired):  # its pipe closes a moment before it is gone
            self._popen.wait(timeout=5.0)
        code = self._popen.poll()
        if code == -9:  # SIGKILL, a name that Windows does not have
            return "signal 9", "somebody killed it, or memory ran out; run it again, with less traffic if need be"
        self._said.seek(0)
        said = self._said.read().decode(errors="replace").split("\n")
        last_words = next((f"it last said: {line.strip()}; " for line in reversed(said) if line.strip()), "")
        how = f"signal {-code}" if code is not None and code < 0 else f"exit code {code}"
        return how, last_words + "try the same input in the simulator itself"

    def end(self) -> None:
        """End the process, if it still lives, and remove what it left in its scratch folder."""
        self._popen.kill()
        self._popen.wait()
        if os.getpid() == self._owner:
            shutil.rmtree(self._scratch, ignore_errors=True)
        self._replies.close()
        self._said.close()
        with suppress(OSError):  # a request may be left that nobody read
            self._requests.close()


def _end_idle() -> None:
    while _Process.idle:
        _Process.idle.pop().end()


atexit.register(_end_idle)

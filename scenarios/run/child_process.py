"""A process with code of the user: a tracker or own metrics, apart from ground truth, limits and grading.

It knows its standard input and output and nothing of the run: its command line, environment and working folder name no
path of the scenario. Time is measured here. What is left of its family at the end is killed, see `supervisor`.
"""

import json
import os
import pickle
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from luxloop.scenarios.run.supervisor import remove

SUPERVISOR = str(Path(__file__).with_name("supervisor.py"))
PART_BYTES = 1 << 20
"""Largest part of an answer that is read at once [bytes]: the length that an answer states may be wrong."""
END_S = 5.0
"""Time for a process to end after its input is closed [s]."""
KEPT = frozenset({
    "PATH", "HOME", "USER", "LOGNAME", "LANG", "LANGUAGE", "TZ", "TMPDIR", "LD_LIBRARY_PATH", "VIRTUAL_ENV",
    "CONDA_PREFIX", "PYTHONHASHSEED",
})  # fmt: skip
KEPT_PREFIXES = ("LC_", "NUMBA_", "OMP_", "MKL_", "OPENBLAS_", "CUDA_")
"""Variables of the environment that the process gets."""


class ChildError(Exception):
    """The process ended, or does not keep its protocol."""


class ChildTimeoutError(Exception):
    """The process gave no answer in time."""


class ChildProcess:
    """A running process.

    Parameters
    ----------
    arguments
        Program and arguments.
    """

    def __init__(self, arguments: list[str]) -> None:
        self._control, other = socket.socketpair()
        with other:
            self._supervisor = subprocess.Popen(
                [sys.executable, "-I", "-S", SUPERVISOR, str(other.fileno())],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, pass_fds=[other.fileno()], cwd="/",
                env=environment(), start_new_session=True,
            )  # fmt: skip
        # The supervisor makes the folder: only then does a judge that is killed at any time leave none.
        self._folder = str(Path(tempfile.gettempdir(), f"luxloop-device-{uuid.uuid4().hex}"))
        assert self._supervisor.stdin
        assert self._supervisor.stdout
        self._input, self._output = self._supervisor.stdin.fileno(), self._supervisor.stdout.fileno()
        for descriptor in (self._input, self._output):
            os.set_blocking(descriptor, False)
        self._control.sendall(json.dumps([self._folder, *arguments]).encode() + b"\n")

    def __del__(self) -> None:
        with suppress(AttributeError):  # it was never started
            self.close()

    def send(self, data: bytes, deadline: float) -> None:
        """Write all of `data` until `deadline` on the monotonic clock.

        Raises
        ------
        ChildError
            The process ended, or has written more than was received: the answer to a request that it did not know.
        ChildTimeoutError
            It does not read in time.
        """
        if select.select([self._output], [], [], 0.0)[0]:
            raise ChildError("answered before it was asked" if os.read(self._output, 1) else self._ending())
        view = memoryview(data)
        while view:
            if not select.select([], [self._input], [], _left(deadline))[1]:
                raise ChildTimeoutError
            try:
                view = view[os.write(self._input, view) :]
            except BrokenPipeError as error:
                raise ChildError(self._ending()) from error

    def receive(self, count: int, deadline: float) -> bytes:
        """Read `count` bytes until `deadline` on the monotonic clock."""
        data = bytearray()
        while len(data) < count:
            ready = select.select([self._output, self._control.fileno()], [], [], _left(deadline))[0]
            if not ready or time.monotonic() > deadline:  # it may write a byte at a time for ever
                raise ChildTimeoutError
            part = os.read(self._output, min(count - len(data), PART_BYTES)) if self._output in ready else b""
            if not part:
                raise ChildError(self._ending())
            data += part
        return bytes(data)

    def finish(self) -> None:
        """Close the input, and wait for the end.

        Raises
        ------
        ChildError
            The process does not end, or with a code other than 0.
        """
        assert self._supervisor.stdin
        self._supervisor.stdin.close()
        code = self._code(END_S)
        if code is None:
            raise ChildError(f"was still running {END_S:g} s after its input was closed")
        if code:
            raise ChildError(_said(code))

    def close(self) -> None:
        """Kill the process with its family."""
        self._control.close()
        with suppress(ProcessLookupError):
            os.kill(self._supervisor.pid, signal.SIGCONT)  # the family may have stopped it
        try:
            self._supervisor.wait(END_S)
        except subprocess.TimeoutExpired:
            self._supervisor.kill()
            self._supervisor.wait()
        remove(self._folder)  # the family may have killed its supervisor
        for stream in (self._supervisor.stdin, self._supervisor.stdout):
            if stream:
                stream.close()

    def _code(self, limit_s: float) -> int | None:
        """Return the exit code, negative for a signal; None if it has not ended in time."""
        self._control.settimeout(limit_s)
        try:
            answer = self._control.recv(64)
        except TimeoutError:
            return None
        return int(answer) if answer else -signal.SIGKILL  # with its supervisor

    def _ending(self) -> str:
        """Return how the process ended: it closed a pipe, so it has ended or is about to."""
        code = self._code(1.0)
        return "closed its standard input or output" if code is None else _said(code)


def environment() -> dict[str, str]:
    """Return the environment of a child process."""
    return {name: value for name, value in os.environ.items() if name in KEPT or name.startswith(KEPT_PREFIXES)}


def _left(deadline: float) -> float:
    return max(0.0, deadline - time.monotonic())


def _said(code: int) -> str:
    if code >= 0:
        return f"ended with exit code {code}"
    named = {number.value: number.name for number in signal.Signals}
    return f"ended by signal {named.get(-code, -code)}"


BOOT = """\
import json, sys
root, path = json.loads(open(0, "rb", 0, closefd=False).readline())
sys.path.insert(0, root)
import luxloop
sys.path[:] = path
from {} import serve
serve()
"""


def python(module: str) -> ChildProcess:
    """Start `serve()` of a module of luxloop in a child process, with the Python path of this process."""
    child = ChildProcess([sys.executable, "-u", "-P", "-s", "-c", BOOT.format(module)])
    root = str(Path(__file__).parents[3])
    child.send(json.dumps([root, [str(place) for place in sys.path]]).encode() + b"\n", time.monotonic() + END_S)
    return child


LENGTH = struct.Struct("<I")
"""Length of the answer [bytes]."""


def ask(module: str, request: object, answer_max: int, deadline: float) -> Any:
    """Start a process of `module`, whose `serve` calls `answer`, and return its answer.

    Raises
    ------
    ChildError, ChildTimeoutError
        It ends, answers more than `answer_max` bytes, or not until `deadline` on the monotonic clock.
    ValueError
        The answer is not JSON.
    """
    child = python(module)
    try:
        child.send(pickle.dumps(request, protocol=5), deadline)
        (length,) = LENGTH.unpack(child.receive(LENGTH.size, deadline))
        if length > answer_max:
            raise ChildError(f"answered {length} bytes")
        return json.loads(child.receive(length, deadline))
    except RecursionError as error:
        raise ValueError("answered no JSON") from error
    finally:
        child.close()


def answer(reply: Callable[[Any], Any]) -> None:
    """Answer the request by a function of it. What the user's code prints goes to standard error."""
    with os.fdopen(os.dup(0), "rb") as requests:
        request = pickle.load(requests)
    answers = os.dup(1)
    os.dup2(2, 1)
    body = json.dumps(reply(request)).encode()
    try:
        with os.fdopen(answers, "wb") as out:
            out.write(LENGTH.pack(len(body)) + body)
    except OSError:  # the user's code has closed it
        os._exit(1)

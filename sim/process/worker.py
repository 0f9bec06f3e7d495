"""Worker process of `luxloop.sim.process.process_source`: runs a traffic source on request, run after run.

Requests arrive on standard input, replies leave on the original standard output, all pickled. Imports are minimal: only
the source loads its simulator.
"""

import importlib
import os
import pickle
import shutil
import signal
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NoReturn

from luxloop.sim.rare_collection import collect_rarely
from luxloop.sim.source import StartStatus, TrafficError, TrafficSource, watch_start

REPORT_INTERVAL_S = 0.2
"""[s] Least time between two reports of one activity."""
REMOVALS = 100
"""Attempts to remove the temporary files; a disk may refuse all."""


@dataclass(frozen=True, slots=True)
class StartRun:
    """Request for a new run. The reply is (obstacles, origin, warnings, ego), or an error that the parent raises.

    Any number of `StartStatus` comes before the reply.
    """

    source: bytes
    """Pickled `TrafficSource` before its reset; it is unpickled after `path` is applied."""
    seed: int
    ahead: int
    """Frames to compute in advance."""
    folder: str
    """The parent's working folder, since paths in the source may be relative."""
    path: list[str]
    """The parent's `sys.path`."""


@dataclass(frozen=True, slots=True)
class Preload:
    """Request to import a module that the next run will need. It has no reply; a failure is left to that run."""

    module: str


class Request(Enum):
    """Requests without arguments. An `EgoCommand` is a request, too; its reply is None."""

    STEP = 0
    """Request for one frame. The reply is a `WorldFrame`."""
    CLOSE = 1
    """End of the run. The reply is `CLOSE`, after all frames already computed."""
    PING = 2
    """Check for life between two runs. The reply is `PING`."""


def serve(scratch: str) -> NoReturn:
    """Serve one run after the other, until the parent kills this process or dies.

    Temporary files go to a new folder `scratch`. The parent removes it; if the parent dies, this process does.
    """
    collect_rarely()
    Path(scratch).mkdir(mode=0o700)
    # A terminal or a job scheduler signals all processes; the parent handles it.
    _set_action(("SIGINT", "SIGTERM", "SIGHUP"), signal.SIG_IGN)
    tempfile.tempdir = scratch
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # output of the simulator must not mix with the replies

    def send(reply: object) -> None:
        try:
            pickle.dump(reply, replies, protocol=5)
            replies.flush()
        except BrokenPipeError:
            _end(scratch)

    requests: SimpleQueue[Any] = SimpleQueue()
    threading.Thread(target=_read_requests, args=(requests, scratch), daemon=True).start()
    while True:
        request = requests.get()
        if request is Request.PING:
            send(request)
        elif isinstance(request, Preload):
            with suppress(Exception):
                importlib.import_module(request.module)
        else:
            _serve_run(request, requests, send)


def _read_requests(requests: "SimpleQueue[Any]", scratch: str) -> None:
    """Queue incoming requests. End this process at the end of the input, when the parent is gone."""
    try:
        while True:
            requests.put(pickle.load(sys.stdin.buffer))
    except (EOFError, pickle.UnpicklingError):  # the latter if the parent dies while it writes a request
        _end(scratch)
    except BaseException:
        traceback.print_exc()
        os._exit(1)


def _end(scratch: str) -> NoReturn:
    """End this process, whose parent is gone, and remove its temporary files.

    The other thread may write files meanwhile, which makes a removal fail. It cannot make the folder again.
    """
    for _ in range(REMOVALS):
        shutil.rmtree(scratch, ignore_errors=True)
        if not Path(scratch).exists():
            break
        time.sleep(0.02)
    os._exit(0)


def _serve_run(start: StartRun, requests: "SimpleQueue[Any]", send: Callable[[object], None]) -> None:
    """Serve one run, from its start to `Request.CLOSE`."""
    _clear_stderr()
    os.chdir(start.folder)
    sys.path[:] = start.path
    source: TrafficSource = pickle.loads(start.source)
    watch_start(source, _throttled(send))
    start_reply = _attempt(lambda: (source.reset(start.seed), source.origin, source.warnings, source.ego_name))
    # pygame, which highway-env imports, handles crashes: it prints a list of modules and ends by SIGABRT.
    _set_action(("SIGSEGV", "SIGBUS", "SIGFPE"), signal.SIG_DFL)
    send(start_reply)
    frames = _frames(source)
    pending = 0 if isinstance(start_reply, Exception) else start.ahead
    while True:
        while not pending or not requests.empty():
            request = requests.get()
            if request is Request.STEP:
                pending += 1
            elif request is Request.CLOSE:
                source.close()
                send(Request.CLOSE)
                return
            else:
                send(_attempt(partial(source.apply, request)))
        send(next(frames))
        pending -= 1


def _throttled(send: Callable[[object], None]) -> Callable[[StartStatus], None]:
    """Return a report that sends every new activity, and its progress now and then."""
    last, activity = 0.0, ""

    def report(status: StartStatus) -> None:
        nonlocal last, activity
        now = time.monotonic()
        if status.activity != activity or now > last + REPORT_INTERVAL_S:
            send(status)
            last, activity = now, status.activity

    return report


def _set_action(names: tuple[str, ...], action: signal.Handlers) -> None:
    """Set the action of those of these signals that the operating system has."""
    for name in names:
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), action)


def _clear_stderr() -> None:
    """Empty the file behind standard error, whose end the parent quotes if this process dies."""
    os.truncate(2, 0)
    os.lseek(2, 0, os.SEEK_SET)


def _frames(source: TrafficSource) -> Iterator[object]:
    """Yield all frames, then repeat the error that ended them: a failed source is not stepped again."""
    while not isinstance(reply := _attempt(source.step), Exception):
        yield reply
    while True:
        yield reply


def _attempt(call: Callable[[], object]) -> object:
    """Return the result of a call, or its error if that is of the traffic or of the system, as a missing permission.

    Other errors are bugs and keep their traceback.
    """
    try:
        return call()
    except (TrafficError, OSError) as error:
        return error
    except Exception as error:
        return internal_error(f"{type(error).__name__} in the traffic process: {error}", traceback.format_exc())


def internal_error(message: str, trace: str) -> RuntimeError:
    """Return the error of a bug in this process, with its traceback as a note."""
    failure = RuntimeError(message)
    failure.add_note(trace)
    return failure

"""The far end of `sim.process.process_source`: a process that plays a traffic source as its parent asks, run after run.

Requests come on standard input, replies go to what was standard output, all pickled. Light to import: no more is loaded
here than the source itself needs.
"""

import os
import pickle
import shutil
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from functools import partial
from queue import SimpleQueue
from typing import Any, NoReturn

from sim.source import TrafficError, TrafficSource


@dataclass(frozen=True, slots=True)
class Start:
    """Request a new run. The reply is (obstacles, origin); a reply that is an error is for the parent to raise."""

    source: bytes
    """A pickled `TrafficSource` that was not reset yet; it is not unpickled before `path` is in force."""
    seed: int
    ahead: int
    """Frames that may be computed before they are asked for."""
    folder: str
    """The parent's working folder, for the source may be made with relative paths."""
    path: list[str]
    """The parent's `sys.path`."""


class Order(Enum):
    """Requests without further words. An `EgoCommand` is a request, too; the reply to it is None."""

    STEP = 0
    """One frame more is wanted. The reply is a `WorldFrame`."""
    CLOSE = 1
    """End the run. The reply is this very order, after the frames that were on their way."""
    ANSWER = 2
    """Between two runs: say that you live, by this very order."""


def serve(scratch: str) -> NoReturn:
    """Play one run after the other, until the parent ends this process or dies itself.

    Temporary files go into the folder `scratch`, which the survivor of the two processes removes.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal's Ctrl-C comes here as well; what follows is the parent's
    tempfile.tempdir = scratch
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a simulator prints must not get among the replies

    def send(reply: object) -> None:
        pickle.dump(reply, replies, protocol=5)
        replies.flush()

    requests: SimpleQueue[Any] = SimpleQueue()
    threading.Thread(target=_listen, args=(requests, scratch), daemon=True).start()
    while True:
        request = requests.get()
        if request is Order.ANSWER:
            send(request)
        else:
            _play(request, requests, send)


def _listen(requests: "SimpleQueue[Any]", scratch: str) -> None:
    """Queue requests as they come. There can be no more when the parent is gone: then this process ends, too."""
    try:
        while True:
            requests.put(pickle.load(sys.stdin.buffer))
    except EOFError:
        shutil.rmtree(scratch, ignore_errors=True)
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        os._exit(1)


def _play(start: Start, requests: "SimpleQueue[Any]", send: Callable[[object], None]) -> None:
    """Play one run, from its start to the order to close."""
    _forget_what_was_said()
    os.chdir(start.folder)
    sys.path[:] = start.path
    source: TrafficSource = pickle.loads(start.source)
    opening = _attempt(lambda: (source.reset(start.seed), source.origin))
    send(opening)
    frames = _frames(source)
    wanted = 0 if isinstance(opening, Exception) else start.ahead
    while True:
        while not wanted or not requests.empty():
            request = requests.get()
            if request is Order.STEP:
                wanted += 1
            elif request is Order.CLOSE:
                source.close()
                send(Order.CLOSE)
                return
            else:
                send(_attempt(partial(source.apply, request)))
        send(next(frames))
        wanted -= 1


def _forget_what_was_said() -> None:
    """Empty the file behind standard error, which the parent quotes from when this process dies."""
    os.truncate(2, 0)
    os.lseek(2, 0, os.SEEK_SET)


def _frames(source: TrafficSource) -> Iterator[object]:
    """Yield frame after frame, then forever the error that ended them: what failed once is not stepped again."""
    while not isinstance(reply := _attempt(source.step), Exception):
        yield reply
    while True:
        yield reply


def _attempt(call: Callable[[], object]) -> object:
    """Return what the call returns or raises; an error that is not traffic's is our mistake and keeps its traceback."""
    try:
        return call()
    except TrafficError as error:
        return error
    except Exception as error:
        told = RuntimeError(f"{type(error).__name__} in the traffic's own process: {error}")
        told.add_note(traceback.format_exc())
        return told

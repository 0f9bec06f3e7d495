"""Process of a tracker in Python: it imports the user's code, makes trackers and steps the last one.

Requests are pickled and come from the judge. Answers are a length, a kind and a body, and are never pickled. What the
tracker prints goes to standard error.
"""

import os
import pickle
from pathlib import Path
from typing import Any, BinaryIO

from luxloop.scenarios.run import output_checks, user_code
from luxloop.scenarios.run.output_checks import BrokenOutputError, OutputCheck
from luxloop.scenarios.run.record_messages import ANSWER, TEXT_MAX, Kind, encode
from luxloop.sim.rare_collection import collect_rarely
from luxloop.tracker.scan import Scan


def serve() -> None:
    """Answer requests until the input ends."""
    collect_rarely()
    requests, answers = os.fdopen(os.dup(0), "rb"), os.dup(1)
    with Path(os.devnull).open("rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)
    server = _Server(requests, answers)
    try:
        while server.answer():
            pass
    except (OSError, pickle.UnpicklingError):  # the tracker has closed its connection, or read from it
        os._exit(1)


class _Server:
    """The user's tracker and its connections to the judge."""

    def __init__(self, requests: BinaryIO, answers: int) -> None:
        self._requests, self._answers, self._process = requests, answers, os.getpid()
        self._make: Any = None
        self._tracker: Any = None
        self._check = OutputCheck()

    def answer(self) -> bool:
        """Answer one request; return False at the end of the input."""
        try:
            name, arguments = pickle.load(self._requests)
        except EOFError:
            return False
        try:
            kind, body = getattr(self, f"_{name}")(*arguments)
        except (BrokenOutputError, user_code.UserCodeError) as error:
            kind, body = Kind.ERROR, str(error).encode(errors="replace")
        except BaseException as error:  # all that a tracker can raise
            kind, body = Kind.ERROR, _described(error).encode(errors="replace")
        if os.getpid() != self._process:
            kind, body = Kind.ERROR, b"forked the tracker, and the copy returned; end it with os._exit"
        body = body if kind is Kind.OUTPUT else body[:TEXT_MAX]
        self._write(ANSWER.pack(len(body), kind) + body)
        if os.getpid() != self._process:
            os._exit(0)
        return True

    def _load(self, spec: str, folder: str) -> tuple[Kind, bytes]:
        self._make = user_code.load(spec, Path(folder))
        lines = (self._make.__doc__ or "").strip().splitlines()
        return Kind.TEXT, (lines[0] if lines else "").encode(errors="replace")

    def _start(self, config: Any) -> tuple[Kind, bytes]:
        self._tracker, self._check = None, OutputCheck()
        self._tracker = self._make(config)
        return Kind.TEXT, b""

    def _step(self, scan: Scan) -> tuple[Kind, bytes]:
        output = self._tracker.step(output_checks.locked(scan))
        try:
            return Kind.OUTPUT, encode(*(output if isinstance(output, tuple) else (output, None)))
        except Exception:  # this check says which field is wrong, or converts it
            return Kind.OUTPUT, encode(*self._check.checked(output, scan))

    def _write(self, data: bytes) -> None:
        view = memoryview(data)
        while view:
            view = view[os.write(self._answers, view) :]


def _described(error: BaseException) -> str:
    return f"{user_code.place_of(error, (__file__,))}raised {user_code.reason_of(error)}"

"""`luxloop check-tracker` on a tracker of the user: the checks run in a process of their own, with the tracker."""

import json
import os
import pickle
import struct
import time
from pathlib import Path

from luxloop.scenarios.check_tracker.check_drives import CheckDrive
from luxloop.scenarios.check_tracker.sequence_checks import Findings, examine
from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.run import child_process, user_code
from luxloop.scenarios.run.child_process import ChildError, ChildTimeoutError
from luxloop.scenarios.run.output_checks import Fault
from luxloop.scenarios.run.process_tracker import START_FACTOR, STEP_TIMEOUT_S

LENGTH = struct.Struct("<I")
ANSWER_MAX = 1 << 24
"""Longest answer [bytes]."""
ENDED = "accepts every scan"
"""Check that fails if the process does not answer."""


def examine_apart(spec: str, drives: list[CheckDrive]) -> Findings:
    """Check a tracker on all drives.

    Raises
    ------
    DeviceError
        It cannot be imported.
    """
    deadline = time.monotonic() + START_FACTOR * STEP_TIMEOUT_S
    child = child_process.python(__name__)
    try:
        child.send(pickle.dumps((spec, str(Path.cwd()), drives), protocol=5), deadline)
        (length,) = LENGTH.unpack(child.receive(LENGTH.size, deadline))
        if length > ANSWER_MAX:
            raise ChildError(f"answered {length} bytes")
        answer = json.loads(child.receive(length, deadline))
        found = Findings(tuple(Fault(*map(str, fault)) for fault in answer["faults"]), frozenset(answer["done"]))
    except ChildTimeoutError:
        return _ended(f"took more than {START_FACTOR * STEP_TIMEOUT_S:g} s")
    except (ChildError, ValueError, KeyError, TypeError) as error:
        return _ended(f"its process {error}")
    finally:
        child.close()
    if answer["error"]:
        raise DeviceError(f"--tracker {spec}: {answer['error']}")
    return found


def _ended(what: str) -> Findings:
    return Findings((Fault(ENDED, what, "one of the drives"),), frozenset())


def serve() -> None:
    """Answer one request: check a tracker of the user in this process."""
    with os.fdopen(os.dup(0), "rb") as requests:
        spec, folder, drives = pickle.load(requests)
    answers = os.dup(1)
    os.dup2(2, 1)
    answer: dict[str, object] = {"error": "", "faults": [], "done": []}
    try:
        found = examine(user_code.load(spec, Path(folder)), drives)
        answer |= {"faults": list(found.faults), "done": sorted(found.done)}
    except user_code.UserCodeError as error:
        answer["error"] = str(error)
    body = json.dumps(answer).encode()
    with os.fdopen(answers, "wb") as out:
        out.write(LENGTH.pack(len(body)) + body)

"""`luxloop check-tracker` on a tracker of the user: the checks run in a process of their own, with the tracker."""

import time
from pathlib import Path

from luxloop.scenarios.check_tracker.check_drives import CheckDrive
from luxloop.scenarios.check_tracker.sequence_checks import Findings, examine
from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.run import one_request, user_code
from luxloop.scenarios.run.child_process import ChildError, ChildTimeoutError
from luxloop.scenarios.run.output_checks import Fault
from luxloop.scenarios.run.process_tracker import START_FACTOR, STEP_TIMEOUT_S

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
    try:
        answer = one_request.ask(__name__, (spec, str(Path.cwd()), drives), ANSWER_MAX, deadline)
        found = Findings(tuple(Fault(*map(str, fault)) for fault in answer["faults"]), frozenset(answer["done"]))
    except ChildTimeoutError:
        return _ended(f"took more than {START_FACTOR * STEP_TIMEOUT_S:g} s")
    except (ChildError, ValueError, KeyError, TypeError) as error:
        return _ended(f"its process {error}")
    if answer["error"]:
        raise DeviceError(f"--tracker {spec}: {answer['error']}")
    return found


def _ended(what: str) -> Findings:
    return Findings((Fault(ENDED, what, "one of the drives"),), frozenset())


def serve() -> None:
    """Answer one request: check a tracker of the user in this process."""
    one_request.answer(_found)


def _found(request: tuple[str, str, list[CheckDrive]]) -> dict[str, object]:
    spec, folder, drives = request
    try:
        found = examine(user_code.load(spec, Path(folder)), drives)
    except user_code.UserCodeError as error:
        return {"error": str(error), "faults": [], "done": []}
    return {"error": "", "faults": list(found.faults), "done": sorted(found.done)}

"""One request to a process with code of the user. The request is pickled, the answer is JSON and never pickled."""

import json
import os
import pickle
import struct
from collections.abc import Callable
from typing import Any

from luxloop.scenarios.run import child_process
from luxloop.scenarios.run.child_process import ChildError

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
    child = child_process.python(module)
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

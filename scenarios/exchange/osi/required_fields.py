"""Fields without which a message of OSI has no boxes; every field of protobuf may be missing."""

from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import betterosi as osi

from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.osi.base_values import time_of


def timed(path: Path, messages: Iterable[Any]) -> Iterator[tuple[float, Any]]:
    """Yield the time [s] of each message, and the message.

    Raises
    ------
    TracksError
        One has no time; messages of a type are counted from 1.
    """
    number: Counter[str] = Counter()
    for message in messages:
        name = type(message).__name__
        number[name] += 1
        if message.timestamp is None:
            raise TracksError(f"{path}: osi3.{name} {number[name]}: no timestamp; give each message its time")
        yield time_of(message.timestamp), message


def object_id(path: Path, time_s: float, identifier: osi.Identifier | None, field: str = "id") -> int:
    """Return the id of an object.

    Raises
    ------
    TracksError
        It has none.
    """
    if identifier is None:
        raise TracksError(f"{path}: time {time_s:g} s: an object without {field}; give each object an id")
    return int(identifier.value)

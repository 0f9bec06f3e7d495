"""Tracks and traces as bytes: a JSON head with type and shape of each array, and the arrays.

A device writes them and the judge reads them, so that reading executes nothing and makes arrays of numbers only.
"""

import json
import math
import struct
from enum import IntEnum
from typing import Any

import numpy as np

from luxloop.tracker.records import Boxes, Candidates, Linkage, Segments, StepTrace, Tracks

ANSWER = struct.Struct("<IB")
"""Length of the body [bytes] and kind of an answer."""
TEXT_MAX = 4000
"""Longest text of an answer [bytes]."""
HEAD = struct.Struct("<I")
"""Length of the JSON head of an output [bytes]."""
HEAD_MAX = 1 << 16
"""Longest head [bytes]."""
RECORDS: dict[str, type] = {
    "tracks": Tracks, "segments": Segments, "linkage": Linkage, "candidates": Candidates, "boxes": Boxes
}  # fmt: skip
"""Records of an answer by name; `track_id` of the trace is an array of its own."""
NUMBERS = frozenset(np.dtype(code).newbyteorder("<").str for code in "?bBhHiIlLqQefd")
"""Types of arrays."""
TRACE = ("segments", "linkage", "candidates", "boxes")


class Kind(IntEnum):
    """Content of an answer."""

    TEXT = 0
    """UTF-8: the first line of the tracker's documentation after `load`, nothing after `start`."""
    OUTPUT = 1
    """Tracks and trace, see `encode`."""
    ERROR = 2
    """UTF-8: what went wrong."""


def encode(tracks: Tracks, trace: StepTrace | None) -> bytes:
    """Return the bytes of an output of `step`.

    Raises
    ------
    TypeError, AttributeError
        A field is missing, or is no array of numbers where it should be.
    """
    head: dict[str, Any] = {}
    parts: list[bytes] = []
    _add(head, parts, "tracks", tracks)
    if trace is not None:
        for name in TRACE:
            _add(head, parts, name, getattr(trace, name))
        head["track_id"] = _array(trace.track_id, parts)
    text = json.dumps(head).encode()
    return b"".join([HEAD.pack(len(text)), text, *parts])


def decode(body: bytes) -> tuple[Tracks, StepTrace | None]:
    """Return the output of a message.

    Raises
    ------
    ValueError
        The bytes are no such message.
    """
    try:
        (length,) = HEAD.unpack_from(body)
        if length > HEAD_MAX:
            raise ValueError(f"a head of {length} bytes")
        head, start = json.loads(body[HEAD.size : HEAD.size + length]), HEAD.size + length
        records: dict[str, Any] = {}
        for name, fields in head.items():
            if name == "track_id":
                records[name], start = _read(fields, body, start)
                continue
            values = {}
            for field, described in fields.items():
                values[field], start = _read(described, body, start)
            records[name] = RECORDS[name](**values)
        tracks = records.pop("tracks")
        return tracks, StepTrace(**records) if records else None
    except (struct.error, KeyError, TypeError, ValueError, AttributeError, RecursionError, OverflowError) as error:
        raise ValueError(f"answered no record ({error})") from error


def _add(head: dict[str, Any], parts: list[bytes], name: str, record: Any) -> None:
    """Describe the fields of a record in `head`, and append its arrays to `parts`."""
    if not isinstance(record, RECORDS[name]):
        raise TypeError(f"{name} is {type(record).__name__}")
    described: dict[str, Any] = {}
    for field in RECORDS[name].__dataclass_fields__:  # type: ignore[attr-defined]
        value = getattr(record, field)
        if field == "count" and isinstance(value, int | np.integer):
            described[field] = {"value": int(value)}
        elif field == "models" and isinstance(value, tuple) and all(type(model) is str for model in value):
            described[field] = {"names": value}
        elif value is None:
            described[field] = {"value": None}
        else:
            described[field] = _array(value, parts)
    head[name] = described


def _array(value: Any, parts: list[bytes]) -> dict[str, Any]:
    if not (isinstance(value, np.ndarray) and _is_number(value.dtype)):
        raise TypeError(f"{type(value).__name__} is no array of numbers")
    parts.append(value.tobytes())
    return {"type": value.dtype.newbyteorder("<").str, "shape": value.shape}


def _is_number(dtype: "np.dtype[Any]") -> bool:
    return dtype.isnative and dtype.newbyteorder("<").str in NUMBERS


def _read(described: dict[str, Any], body: bytes, start: int) -> tuple[Any, int]:
    """Return the value of a field, and the place of the next one in the message."""
    if "names" in described:
        return tuple(map(str, described["names"])), start
    if "type" not in described:
        value = described["value"]
        return None if value is None else int(value), start
    shape = [int(axis) for axis in described["shape"]]
    if described["type"] not in NUMBERS or any(axis < 0 for axis in shape):
        raise ValueError(f"an array of {described['type']} with the shape {shape}")
    dtype, count = np.dtype(described["type"]), math.prod(shape)
    values = np.frombuffer(body, dtype, count, start) if count else np.empty(0, dtype)
    return values.reshape(shape), start + count * dtype.itemsize

"""Scenario files with one or two errors each, as typing, editors and merges produce them."""

import copy
import json
import math
import random
import re
import string
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from support.paths import CATALOG, EXAMPLES

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.metrics.definitions import standard_names

ORIGINALS = (*sorted(CATALOG.rglob("*.toml")), *sorted(EXAMPLES.glob("*.toml")))
SHORT_S = 0.16
"""Duration of two frames [s]."""
LONGEST_S = 86_400.0
"""Longest allowed duration of a run [s], a day; a longer one is an error."""

MODEST = (0, -1, 1, 3, 0.5, 90, -180, 1000, 1e-6, 1e6, 1e-12, 1e10, -1e10, 1e12, 2**31, 0.999999)
METRICS = tuple(standard_names())
NUMBERS = (*MODEST, 1e-300, 1e300, -1e300, 2**63 - 1, -(2**63), math.nan, math.inf)
TEXTS = ("", " ", "nowhere", "Überholspur 🚗", "a" * 3000, "../x.xml", "/dev/null", "two\nlines", "\x1b[31m", "%s{0}")
OTHERS = (True, False, [], {}, [[]], [1, "a"], {"kind": "sumo"}, {"min": 1})

Key = tuple[str | int, ...]


@dataclass(frozen=True)
class Mutant:
    """A mutated file."""

    original: Path
    content: bytes
    keys: tuple[str, ...]
    """Names of which the error message must contain one; empty if two keys or the text were mutated."""
    how: str


def mutant(number: int) -> Mutant:
    """Return the mutant of this number, always the same. It runs two frames unless its duration is mutated."""
    rng = random.Random(number)
    original = ORIGINALS[number % len(ORIGINALS)]
    if rng.random() < 0.2:
        how = rng.choice(OF_TEXT)
        return Mutant(original, how(rng, short_text(original)), (), how.__name__)
    document = copy.deepcopy(_with_defaults(original) if rng.random() < 0.5 else _read(original))
    ways = rng.choices(OF_KEYS, k=rng.choice((1, 1, 1, 1, 2)))
    done = [(way.__name__, *way(rng, document)) for way in ways]
    duration = document.get("duration_s")
    if type(duration) in (int, float) and SHORT_S < duration <= LONGEST_S:
        document["duration_s"] = SHORT_S
    return Mutant(original, toml(document).encode(), done[0][1] if len(done) == 1 else (), f"{done}")


def short_text(original: Path) -> str:
    """Return the text of a file, with a duration of two frames."""
    text = original.read_text(encoding="utf-8")
    return re.sub(r"^duration_s = .*$", f"duration_s = {SHORT_S}", text, count=1, flags=re.MULTILINE)


def toml(document: dict[str, Any]) -> str:
    """Return a document as TOML, with inline tables."""
    return "".join(f"{_key(key)} = {_value(value)}\n" for key, value in document.items())


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _value(key)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(key)} = {_value(child)}" for key, child in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(child) for child in value) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)


@cache
def _read(original: Path) -> dict[str, Any]:
    return tomllib.loads(original.read_text(encoding="utf-8"))


@cache
def _with_defaults(original: Path) -> dict[str, Any]:
    """Return the document with all defaults, so that every existing key is mutated."""
    return _without_none(Scenario.load(original).model_dump(mode="json"))


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_none(child) for key, child in value.items() if child is not None}
    return [_without_none(child) for child in value] if isinstance(value, list) else value


def _keys(value: Any, above: Key = ()) -> Iterator[Key]:
    for step, child in value.items() if isinstance(value, dict) else enumerate(value):
        yield (*above, step)
        if isinstance(child, dict | list):
            yield from _keys(child, (*above, step))


def _pick(rng: random.Random, document: dict[str, Any]) -> tuple[Any, Key]:
    """Return a random key, and the table or list that contains it."""
    key = rng.choice(list(_keys(document)) or [("seed",)])
    place = document
    for step in key[:-1]:
        place = place[step]
    return place, key


def _names(key: Key) -> tuple[str, ...]:
    """Return the last name in a key (for an item of a list, the list's), and that of its table if it is nested."""
    names = [step for step in key if isinstance(step, str)]
    return tuple(names[-2:] if len(names) > 2 else names[-1:])


def _drop(rng, document):
    place, key = _pick(rng, document)
    value = place.pop(key[-1])
    return _names(key), f"{key} = {value!r:.60}"


def _misspell(rng, document):
    place, key = _pick(rng, document)
    if isinstance(place, list):
        return _replace(rng, document)
    at = rng.randrange(len(key[-1]) + 1)
    wrong = (
        key[-1][:at] + rng.choice([*string.ascii_letters, ".", " ", "ß", '"', "_m"]) + key[-1][at + rng.randrange(2) :]
    )
    place[wrong] = place.pop(key[-1])
    return (*_names(key), wrong), f"{key}: {wrong}"


def _replace(rng, document):
    place, key = _pick(rng, document)
    place[key[-1]] = copy.deepcopy(rng.choice([*NUMBERS, *TEXTS, *OTHERS]))
    return _names(key), f"{key} = {place[key[-1]]!r:.60}"


def _number(rng, document):
    """Replace a number by another one."""
    for _ in range(100):
        place, key = _pick(rng, document)
        if type(place[key[-1]]) in (int, float):
            number_type = type(place[key[-1]])
            value = rng.choice([*MODEST, *NUMBERS, -place[key[-1]], place[key[-1]] * 1e6])
            place[key[-1]] = number_type(value) if math.isfinite(value) and abs(value) < 2**63 else value
            return _names(key), f"{key} = {place[key[-1]]!r:.60}"
    return _replace(rng, document)


def _text(rng, document):
    """Replace a text by another one."""
    for _ in range(100):
        place, key = _pick(rng, document)
        if isinstance(place[key[-1]], str):
            place[key[-1]] = rng.choice([*TEXTS, place[key[-1]][:-1], place[key[-1]].upper(), place[key[-1]] + "x"])
            return _names(key), f"{key} = {place[key[-1]]!r:.60}"
    return _replace(rng, document)


def _retype(rng, document):
    """Give the value as a text, or in a list or table."""
    place, key = _pick(rng, document)
    value = place[key[-1]]
    place[key[-1]] = rng.choice([str(value), [value], {"value": value}])
    return _names(key), f"{key} = {place[key[-1]]!r:.60}"


def _move(rng, document):
    """Move a key to another table."""
    place, key = _pick(rng, document)
    value = place.pop(key[-1])
    tables = [table for table in [document, *document.values()] if isinstance(table, dict)]
    rng.choice(tables)[str(key[-1])] = value
    return (str(key[-1]), *map(str, key[-2:])), f"{key}"


def _expect(rng, document):
    """Set a limit on a metric, or on an unknown one."""
    name = rng.choice([*standard_names(), "track.hotta", "hota", "", "fit.best", "fit..iou_mean", "track.Überholt"])
    limit = {end: rng.choice(NUMBERS) for end in rng.sample(["min", "max", "unit", "mox"], rng.randrange(4))}
    document["expect"] = {name: limit}
    return (name,), f"{name} = {limit}"


OF_KEYS = (_drop, _misspell, _replace, _number, _number, _number, _number, _text, _retype, _move, _expect)


def _truncate(rng, text):
    return text.encode()[: rng.randrange(len(text))]


def _invalid_utf8(rng, text):
    raw, at = text.encode(), rng.randrange(len(text))
    return raw[:at] + rng.choice([b"\xff", b"\xc3\x28", b"\x80", b"\xed\xa0\x80", b"\xfe\xff"]) + raw[at:]


def _utf16(_, text):
    return text.encode("utf-16")


def _byte_order_mark(_, text):
    return b"\xef\xbb\xbf" + text.encode()


def _change_byte(rng, text):
    raw = bytearray(text.encode())
    raw[rng.randrange(len(raw))] = rng.choice([0, 9, 10, 13, *b'"=[]{}#.,\\ x7-', 127])
    return bytes(raw)


def _line(rng, lines):
    return rng.choice([i for i, line in enumerate(lines) if line.strip()])


def _repeat_line(rng, text):
    lines = text.splitlines(keepends=True)
    at = _line(rng, lines)
    return "".join([*lines[:at], lines[at], *lines[at:]]).encode()


def _remove_line(rng, text):
    lines = text.splitlines(keepends=True)
    del lines[_line(rng, lines)]
    return "".join(lines).encode()


def _move_line(rng, text):
    lines = text.splitlines(keepends=True)
    lines.insert(rng.randrange(len(lines)), lines.pop(_line(rng, lines)))
    return "".join(lines).encode()


def _merge_conflict(rng, text):
    lines = text.splitlines(keepends=True)
    at = _line(rng, lines)
    return "".join(
        [*lines[:at], "<<<<<<< HEAD\n", lines[at], "=======\n", lines[at], ">>>>>>> mine\n", *lines[at:]]
    ).encode()


def _nest_deeply(rng, text):
    depth = rng.choice([50, 500, 100_000])
    deep = rng.choice(
        ["x = " + "[" * depth + "]" * depth, "x = " + "{a=" * depth + "1" + "}" * depth, ".".join("a" * depth) + " = 1"]
    )
    return f"{deep}\n{text}".encode()


def _unusual_value(rng, text):
    value = rng.choice(
        [
            "9" * 5000,
            "1979-05-27T07:32:00Z",
            "07:32:00",
            "0x_1",
            "1__0",
            "+nan",
            "-inf",
            "0b11",
            "'''a\nb'''",
            "1e99999",
        ]
    )
    return re.sub(r"^(seed|duration_s) = .*$", rf"\1 = {value}", text, count=1, flags=re.MULTILINE).encode()


def _empty(rng, _):
    return rng.choice([b"", b"\n", b"\0" * 100, b"# nothing\n", b"[[traffic]]\n", b"[traffic]\n", b"PK\x03\x04"])


def _carriage_returns(_, text):
    return text.replace("\n", "\r").encode()


OF_TEXT = (
    _truncate, _invalid_utf8, _utf16, _byte_order_mark, _change_byte, _change_byte, _repeat_line, _remove_line,
    _move_line, _merge_conflict, _nest_deeply, _unusual_value, _empty, _carriage_returns,
)  # fmt: skip

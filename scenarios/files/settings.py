"""Keys of a scenario file set on the command line, `--set noise.rain.rate_mm_per_h=3`, or from Python by a mapping."""

import copy
import json
import re
import tomllib
from collections.abc import Iterable, Mapping
from numbers import Integral, Real
from pathlib import PurePath
from typing import Any

from luxloop.scenarios.errors import ScenarioError

Key = list[str | int]

PART = re.compile(r'(?:(?<!^)\.|^)(?:([\w-]+)|"([^"]*)")|(?<!^)\[(\d{1,6})\]')
"""A part of a dotted key: a bare or quoted name, or the number of an item of a list, from 0."""
EXAMPLE = "--set noise.rain.rate_mm_per_h=3"


def applied(document: dict[str, Any], settings: Iterable[str]) -> dict[str, Any]:
    """Return a copy of the document of a scenario file with these keys set, in this order.

    Parameters
    ----------
    document
        Document of a scenario file.
    settings
        Texts KEY=VALUE. KEY is written as in error messages: `traffic.actor[0].x_m`, `expect."track.hota".min`. VALUE
        is TOML; other text is taken as a string, so that it needs no quotes.

    Raises
    ------
    ScenarioError
        A text is not KEY=VALUE, or a part of its key is no table or list of the document.
    """
    changed = copy.deepcopy(document)
    for text in settings:
        key, value = parse(text)
        _assign(changed, key, value, text)
    return changed


def texts(settings: Mapping[str, object] | Iterable[str]) -> list[str]:
    """Return settings as texts KEY=VALUE; those of a mapping from key to value, or texts as they are.

    Raises
    ------
    ScenarioError
        A value cannot be written in TOML.
    """
    if not isinstance(settings, Mapping):
        return list(settings)
    return [f"{key}={_text(key, plain(value))}" for key, value in settings.items()]


def plain(value: object) -> object:
    """Return a value in the types of TOML documents: numbers of numpy as those of Python, paths as texts."""
    match value:
        case bool() | str():
            return value
        case Integral():
            return int(value)
        case Real():
            return float(value)
        case PurePath():
            return str(value)
        case list() | tuple():
            return [plain(item) for item in value]
        case Mapping():
            return {str(key): plain(item) for key, item in value.items()}
    return value


def _text(key: str, value: object) -> str:
    """Return a value as TOML; a text without quotes if it is still read as that text."""
    if isinstance(value, str) and _value(value) == value:
        return value
    try:
        text = _toml(value)
        if _value(text) == value:
            return text
    except TypeError:  # of json, for other types
        pass
    kinds = "a finite number, a text, true or false, or a list or mapping of these"
    raise ScenarioError(f"--set {key}: {value!r} cannot be written in a scenario file; give {kinds}")


def _toml(value: object) -> str:
    if isinstance(value, dict):
        return f"{{{', '.join(f'{_toml(key)} = {_toml(item)}' for key, item in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    return json.dumps(value, ensure_ascii=False)


def parse(text: str) -> tuple[Key, Any]:
    """Return key and value of a text KEY=VALUE.

    Raises
    ------
    ScenarioError
        The text is not of this form.
    """
    key: Key = []
    place = 0
    while found := PART.match(text, place):
        bare, quoted, number = found.groups()
        key.append(int(number) if number else bare or quoted)
        place = found.end()
    if not key or text[place : place + 1] != "=":
        raise ScenarioError(f"--set {text}: should be KEY=VALUE, as in {EXAMPLE}")
    return key, _value(text[place + 1 :])


def _value(text: str) -> Any:
    """Return the value of TOML, or the text itself."""
    try:
        document = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # also a number of more than 4300 digits
        return text
    return document["value"] if document.keys() == {"value"} else text


def _assign(document: dict[str, Any], key: Key, value: Any, text: str) -> None:
    table: Any = document
    for place, part in enumerate(key):
        _check(table, part, key[:place], text)
        if place == len(key) - 1:
            table[part] = value
        else:
            table = table.setdefault(part, {}) if isinstance(part, str) else table[part]


def _check(table: Any, part: str | int, above: Key, text: str) -> None:
    """Check that a part of a key can be set in a table or list."""
    name = ".".join(map(str, above)) or "the file"
    if isinstance(part, int) and isinstance(table, list):
        if part >= len(table):
            raise ScenarioError(f"--set {text}: {name} has {len(table)} items; give a number below that, from 0")
    elif isinstance(part, int) or not isinstance(table, dict):
        kind = "a table" if isinstance(table, dict) else "a list" if isinstance(table, list) else "a single value"
        remedy = f"give the number of an item, {name}[0]" if isinstance(table, list) else "give a key of the file"
        raise ScenarioError(f"--set {text}: {name} is {kind}; {remedy}")

"""Text of a new scenario file."""

import json
import re
import textwrap
import tomllib
from collections.abc import Iterable
from typing import Any

WIDTH = 118
"""Characters of a comment line."""
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def scenario_text(document: dict[str, Any], comments: Iterable[str]) -> str:
    """Return a scenario file with comments at its head.

    Parameters
    ----------
    document
        Content: values, and tables of values.
    comments
        Paragraphs.
    """
    lines = [f"# {line}" for comment in comments for line in textwrap.wrap(" ".join(comment.split()), WIDTH)]
    tables = {key: value for key, value in document.items() if isinstance(value, dict)}
    lines += [f"{_key(key)} = {_value(value)}" for key, value in document.items() if key not in tables]
    for name, table in tables.items():
        lines += ["", f"[{_key(name)}]", *(f"{_key(key)} = {_value(value)}" for key, value in table.items())]
    text = "\n".join(lines) + "\n"
    assert tomllib.loads(text) == document
    return text


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _string(name)


def _value(value: Any) -> str:
    """Return a value in TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    return _string(value) if isinstance(value, str) else json.dumps(value)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")

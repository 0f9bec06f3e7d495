"""One-line error messages from pydantic's validation errors."""

import json
import math
from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from luxloop.tracker import renamed_settings

Json = dict[str, Any]
Key = tuple[str | int, ...]


def value_at(document: Any, key: Key) -> Any:
    """Return the value at a key of a document."""
    for step in key:
        document = document[step]
    return document


def known_keys(key: Key, document: Json, schema: Json) -> str:
    """Return the most similar known keys, or else all known keys."""
    known = sorted({name for table in _tables(key[:-1], document, schema) for name in table["properties"]})
    close = get_close_matches(str(key[-1]), known, n=3)
    return f"did you mean {' or '.join(close)}?" if close else f"known here: {', '.join(known)}"


def choices(key: Key, document: Json, schema: Json) -> str:
    """Return the allowed values of a missing key, if they are fixed."""
    properties = [table["properties"].get(key[-1], {}) for table in _tables(key[:-1], document, schema)]
    values = [json.dumps(choice["const"]) for choice in properties if "const" in choice]
    return f": one of {', '.join(values)}" if values else ""


def _tables(key: Key, document: Json, schema: Json) -> list[Json]:
    """Return the schemas of the tables allowed at `key`, restricted to the `kind` in the document."""
    nodes = [schema]
    for depth, step in enumerate((*key, None)):
        nodes = [table for node in nodes for table in _alternatives(node, schema["$defs"])]
        nodes = [node for node in nodes if _is_kind(node, value_at(document, key[:depth]))]
        if step is not None:
            nodes = [child for node in nodes for child in _below(node, step)]
    return [node for node in nodes if "properties" in node]


def _alternatives(node: Json, definitions: Json) -> Iterator[Json]:
    """Resolve references and unions to plain schemas."""
    if "$ref" in node:
        yield from _alternatives(definitions[node["$ref"].rpartition("/")[2]], definitions)
    elif options := node.get("oneOf") or node.get("anyOf"):
        for option in options:
            yield from _alternatives(option, definitions)
    else:
        yield node


def _is_kind(node: Json, value: Any) -> bool:
    kind = node.get("properties", {}).get("kind", {}).get("const")
    return kind is None or not isinstance(value, dict) or value.get("kind", kind) == kind


def _below(node: Json, step: str | int) -> list[Json]:
    """Return the schema of one key or item, if it has one."""
    child = node.get("items") if isinstance(step, int) else node.get("properties", {}).get(step)
    child = child or node.get("additionalProperties")
    return [child] if isinstance(child, dict) else []


UNKNOWN_KEY = {"extra_forbidden", "unexpected_keyword_argument"}
MISSING = {"missing", "union_tag_not_found"}
LONGEST_VALUE = 60
MOST_ERRORS = 6
"""Largest number of errors in a message."""
SMALLEST, LARGEST = 1e-12, 1e10
"""Absolute values of numbers other than 0, in any unit. Quantities of road traffic lie within, and their products are
finite."""


def explain(error: ValidationError, document: Json, schema: Json) -> str:
    """Return all wrong keys, values and remedies: `traffic.eggo = "a": unknown key; did you mean ego?`.

    Several are numbered, unknown keys first. Of the alternatives of a union, the errors of the likeliest are explained.

    Parameters
    ----------
    error
        Error raised by the validation.
    document
        Validated document.
    schema
        JSON schema of the model, for its known keys.
    """
    groups: dict[Key, list[ErrorDetails]] = {}
    for one in error.errors(include_url=False):
        groups.setdefault(_choice(one, document), []).append(one)
    ranked = sorted(groups.values(), key=lambda errors: _most_specific(errors)["type"] not in UNKNOWN_KEY)
    messages = list(dict.fromkeys(_explain(errors, document, schema) for errors in ranked))
    if len(messages) == 1:
        return messages[0]
    shown = " ".join(f"({number}) {message}" for number, message in enumerate(messages[:MOST_ERRORS], start=1))
    more = len(messages) - MOST_ERRORS
    return f"{len(messages)} errors: {shown}" + (f" and {more} more" if more > 0 else "")


def _explain(errors: list[ErrorDetails], document: Json, schema: Json) -> str:
    """Explain the likeliest of the errors at one place."""
    first = _most_specific(errors)
    key, kind = _key(first, document), first["type"]
    if kind in MISSING:
        return f"{_dotted(key)} is missing; add it{choices(key, document, schema)}"
    if kind in UNKNOWN_KEY:
        given = f"{_dotted(key)} = {_short(first['input'])}"
        if remedy := renamed_settings.remedy(_dotted(key)):
            return f"{given}: {remedy}"
        return f"{given}: unknown key; {known_keys(key, document, schema)}"
    if kind == "union_tag_invalid":
        remedy = f"should be one of {first['ctx']['expected_tags']}"
    elif kind == "literal_error":  # each alternative of a union expects another value
        expected = [error["ctx"]["expected"] for error in errors if error["loc"][-1] == first["loc"][-1]]
        remedy = f"should be {' or '.join(expected)}"
    elif kind == "value_error":
        remedy = str(first["ctx"]["error"])
    else:
        remedy = first["msg"].removeprefix("Input ").replace("an object", "a table")
    value = value_at(document, key)
    # A rule over several keys fails for their table as a whole; its message names the keys.
    return f"{_dotted(key)}: {remedy}" if isinstance(value, dict) else f"{_dotted(key)} = {_short(value)}: {remedy}"


def implausible(value: Any, key: Key = ()) -> str:
    """Return a message on the first number that is too large, too small or not finite; empty if all are plausible."""
    if isinstance(value, dict | list):
        children = value.items() if isinstance(value, dict) else enumerate(value)
        return next((wrong for step, child in children if (wrong := implausible(child, (*key, step)))), "")
    if not isinstance(value, int | float) or value == 0 or SMALLEST <= abs(value) <= LARGEST:
        return ""
    finite = isinstance(value, int) or math.isfinite(value)  # an integer may be too large for a float
    size = f"0, or a number from {SMALLEST:g} to {LARGEST:g} in size" if finite else "a finite number"
    return f"{_dotted(key)} = {_short(value)}: should be {size}"


def _most_specific(errors: list[ErrorDetails]) -> ErrorDetails:
    """Drop errors of union alternatives of another `kind`; prefer a missing `kind`, then an unknown key."""
    wrong_kind = [error for error in errors if error["type"] == "literal_error" and error["loc"][-1] == "kind"]
    others = {error["loc"][:-1] for error in wrong_kind}
    meant = [error for error in errors if not any(error["loc"][: len(loc)] == loc for loc in others)]
    return min(meant or wrong_kind, key=lambda error: (not _lacks_kind(error), error["type"] not in UNKNOWN_KEY))


def _choice(error: ErrorDetails, document: Json) -> Key:
    """Return the key of the error, or that of a union whose alternatives each have errors."""
    key: Key = ()
    for step in error["loc"]:
        value = value_at(document, key)
        if _has(value, step):
            key = (*key, step)
        elif not (isinstance(value, dict) and value.get("kind") == step):  # not the name of the only alternative meant
            is_own_key = step == error["loc"][-1] and error["type"] in UNKNOWN_KEY | MISSING
            return (*key, step) if is_own_key else key
    return key


def _lacks_kind(error: ErrorDetails) -> bool:
    return error["type"] == "missing" and error["loc"][-1] == "kind"


def _key(error: ErrorDetails, document: Json) -> Key:
    """Return the key of the error in the file: pydantic's location without the names of union alternatives."""
    key: Key = ()
    for step in error["loc"]:
        if _has(value_at(document, key), step):
            key = (*key, step)
    if error["type"] == "missing":
        return (*key, error["loc"][-1])
    if error["type"].startswith("union_tag"):
        return (*key, error["ctx"]["discriminator"].strip("'"))
    return key


def _has(value: Any, step: str | int) -> bool:
    if isinstance(step, int):
        return isinstance(value, list) and step < len(value)
    return isinstance(value, dict) and step in value


def _dotted(key: Key) -> str:
    """Spell a key as TOML does: `traffic.actors[2].motion`, `expect."track.hota"`."""
    text = ""
    for step in key:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            text += ("." if text else "") + (f'"{step}"' if "." in step else step)
    return text or "the file"


def _short(value: Any) -> str:
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 3] + "..."

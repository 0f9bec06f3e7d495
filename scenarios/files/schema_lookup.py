"""Known keys and values of a scenario file at a place of the document, from the JSON schema."""

import json
from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

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

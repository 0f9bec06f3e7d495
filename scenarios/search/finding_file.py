"""Scenario file of a finding, ready for the catalog: the failing scenario with its seed and its expectation."""

import copy
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import tomli_w

from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.files.expect import SHIPPED, Limit
from luxloop.scenarios.search.evaluator import Json

HEAD = ("description", "reason", "suite", "seed", "duration_s", "traffic")
"""First keys of the file, in this order; all other keys follow, `[expect]` last."""

_NUMBERS = re.compile(r"\[\n\s*([\w\s.,+-]+?),\n\s*\]")
"""List of numbers or booleans as tomli_w writes it, one item per line."""


def expectation(metric: str, limit: Limit, known_failure: str, tracker: str = SHIPPED) -> Json:
    """Return an `[expect]` table with one limit; `known_failure` describes the failure of `tracker`."""
    table = {"min": limit.min, "max": limit.max, "unit": limit.unit, "need": limit.need, "known_failure": known_failure}
    table["known_failure_of"] = "" if tracker == SHIPPED else tracker
    return {metric: {key: _plain(value) for key, value in table.items() if value not in (None, "")}}


def write(document: Json, made_at: Path, path: Path) -> None:
    """Write a scenario file.

    Parameters
    ----------
    document
        Content of the file.
    made_at
        File to which relative paths in the document refer.
    path
        File to write; relative paths are changed to refer to it.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    moved = _moved(document, made_at.parent, path.parent)
    last = [key for key in moved if key not in (*HEAD, "expect")]
    ordered = {key: moved[key] for key in (*HEAD, *last, "expect") if key in moved}
    try:
        with atomic_file.create(path) as partial:
            partial.write_text(_text(ordered), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot write there ({error.strerror}); choose another folder with --out") from error


def _text(document: Json) -> str:
    """Return TOML text with lists of numbers on one line."""
    return _NUMBERS.sub(lambda found: f"[{' '.join(found[1].split())}]", tomli_w.dumps(document))


def _plain(value: Any) -> Any:
    """Return 0 for 0.0, which is easier to read."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _moved(document: Json, start: Path, new_start: Path) -> Json:
    """Return a copy with relative paths that lead from a new folder to the same files."""
    moved = copy.deepcopy(document)
    for container, key in _paths(moved):
        value = container[key]
        if value:
            container[key] = Path(os.path.relpath(start / value, new_start)).as_posix()
    return moved


def _paths(document: Json) -> Iterator[tuple[Any, str | int]]:
    """Yield the location of every path in a scenario: the list or table, and the index or key."""
    traffic = document["traffic"]
    for key in ("config", "net", "file"):
        if traffic.get("kind") != "highway-env" and key in traffic:
            yield traffic, key
    for key in ("routes", "additional"):
        for index in range(len(traffic.get(key, []))):
            yield traffic[key], index
    if "file" in document.get("rig", {}):
        yield document["rig"], "file"

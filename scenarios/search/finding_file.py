"""The scenario file of a finding: what fails, with which seed, ready for the catalog."""

import copy
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import tomli_w

from scenarios.errors import OutputError
from scenarios.files import atomic_file
from scenarios.files.expect import Limit
from scenarios.search.evaluator import Json

HEAD = ("description", "reason", "suite", "seed", "duration_s", "traffic")
"""The order in which a person reads a scenario; what else there is follows, `[expect]` last."""

_NUMBERS = re.compile(r"\[\n\s*([\w\s.,+-]+?),\n\s*\]")
"""A list of numbers or truth values as tomli_w writes it, each on a line of its own."""


def expectation(metric: str, limit: Limit, known_failure: str) -> Json:
    """Return the `[expect]` table that says what is found to fail."""
    table = {"min": limit.min, "max": limit.max, "unit": limit.unit, "need": limit.need, "known_failure": known_failure}
    return {metric: {key: _plain(value) for key, value in table.items() if value not in (None, "")}}


def write(document: Json, made_at: Path, path: Path) -> None:
    """Write a scenario file.

    Parameters
    ----------
    document
        What stands in it.
    made_at
        Where the paths in it start: a file in that folder.
    path
        The file to write; paths in it are changed so that they start there.

    Raises
    ------
    OutputError
        It cannot be written.
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
    """Write TOML with short lists on one line."""
    return _NUMBERS.sub(lambda found: f"[{' '.join(found[1].split())}]", tomli_w.dumps(document))


def _plain(value: Any) -> Any:
    """Write 0 rather than 0.0, as people do."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _moved(document: Json, start: Path, new_start: Path) -> Json:
    """Return a copy whose paths lead from another folder to the same files."""
    moved = copy.deepcopy(document)
    for place, key in _paths(moved):
        value = place[key]
        if value:
            place[key] = Path(os.path.relpath(start / value, new_start)).as_posix()
    return moved


def _paths(document: Json) -> Iterator[tuple[Any, str | int]]:
    """Yield where paths stand in a scenario: the list or table, and the index or key."""
    traffic = document["traffic"]
    for key in ("config", "net", "file"):
        if traffic.get("kind") != "highway-env" and key in traffic:
            yield traffic, key
    for key in ("routes", "additional"):
        for index in range(len(traffic.get(key, []))):
            yield traffic[key], index
    if "file" in document.get("rig", {}):
        yield document["rig"], "file"

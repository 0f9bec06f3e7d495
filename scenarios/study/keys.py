"""Keys of a scenario file as written in a study: `noise.dropout.random_rate`, `traffic.actor[car].x_m`."""

import copy
import re
from typing import Any

from luxloop.scenarios.errors import StudyError

Json = dict[str, Any]

_STEP = re.compile(r'"([^"]+)"|\[([^\]]+)\]|([^.\[\]"]+)')


def parse(key: str) -> tuple[str, ...]:
    """Split a key into its steps; a step in brackets is the index or the name of a list item.

    Raises
    ------
    StudyError
        The key is malformed.
    """
    steps = tuple(f"[{match[2]}]" if match[2] else match[1] or match[3] for match in _STEP.finditer(key))
    if not steps or _joined(steps) != key.replace('"', ""):
        raise StudyError(
            f"{key}: not a valid key of a scenario file; use the form noise.dropout.random_rate or traffic.actor[0].x_m"
        )
    return steps


def with_values(document: Json, values: dict[str, Any]) -> Json:
    """Return a copy of a scenario document with these keys set; missing tables are created.

    Raises
    ------
    StudyError
        A key names a missing list item, or descends into a plain value.
    """
    changed = copy.deepcopy(document)
    for key, value in values.items():
        *parents, last = parse(key)
        node: Any = changed
        for step in parents:
            node = _child(node, step, key)
        if last.startswith("["):
            node[_index(node, last, key)] = value
        elif isinstance(node, dict):
            node[last] = value
        else:
            raise _not_in_a_table(key, last)
    return changed


def _child(node: Any, step: str, key: str) -> Any:
    if step.startswith("["):
        return node[_index(node, step, key)]
    if not isinstance(node, dict):
        raise _not_in_a_table(key, step)
    return node.setdefault(step, {})


def _index(node: Any, step: str, key: str) -> int:
    """Return the index of a list item given by its index or its `name`."""
    wanted = step[1:-1]
    if isinstance(node, list):
        if wanted.isdecimal() and int(wanted) < len(node):
            return int(wanted)
        names = [item.get("name") if isinstance(item, dict) else None for item in node]
        if names.count(wanted) == 1:
            return names.index(wanted)
    found = f"a list of {len(node)}" if isinstance(node, list) else "not a list"
    raise StudyError(f"{key}: no item {step}: found {found}; give an index from 0 on, or the name of one item")


def _not_in_a_table(key: str, step: str) -> StudyError:
    return StudyError(f"{key}: {step} is not inside a table; select a list item before it, e.g. actor[0]")


def _joined(steps: tuple[str, ...]) -> str:
    return ".".join(steps).replace(".[", "[")

"""Keys of a scenario file as a study names them: `noise.dropout.random_rate`, `traffic.actor[car].x_m`."""

import copy
import re
from typing import Any

from scenarios.errors import StudyError

Json = dict[str, Any]
Step = str | int

_STEP = re.compile(r'"([^"]+)"|\[([^\]]+)\]|([^.\[\]"]+)')


def parse(key: str) -> tuple[str, ...]:
    """Split a key into its steps; what stands in brackets is the number or the name of one of a list."""
    steps = tuple(f"[{match[2]}]" if match[2] else match[1] or match[3] for match in _STEP.finditer(key))
    if not steps or _spell(steps) != key.replace('"', ""):
        raise StudyError(
            f"{key}: no key of a scenario file; write it as in noise.dropout.random_rate or traffic.actor[0].x_m"
        )
    return steps


def with_values(document: Json, values: dict[str, Any]) -> Json:
    """Return a copy of a scenario's document with the values of these keys set; tables on the way are made.

    Raises
    ------
    StudyError
        A step leads to no item of a list, or through a value.
    """
    changed = copy.deepcopy(document)
    for key, value in values.items():
        *way, last = parse(key)
        place: Any = changed
        for step in way:
            place = _below(place, step, key)
        if last.startswith("["):
            place[_index(place, last, key)] = value
        elif isinstance(place, dict):
            place[last] = value
        else:
            raise StudyError(f"{key}: {last} stands in no table; name an item of the list before it, as in actor[0]")
    return changed


def _below(place: Any, step: str, key: str) -> Any:
    if step.startswith("["):
        return place[_index(place, step, key)]
    if not isinstance(place, dict):
        raise StudyError(f"{key}: {step} stands in no table; name an item of the list before it, as in actor[0]")
    return place.setdefault(step, {})


def _index(place: Any, step: str, key: str) -> int:
    """Return which item of a list is meant, by its number or its `name`."""
    wanted = step[1:-1]
    if isinstance(place, list):
        if wanted.isdecimal() and int(wanted) < len(place):
            return int(wanted)
        names = [item.get("name") if isinstance(item, dict) else None for item in place]
        if names.count(wanted) == 1:
            return names.index(wanted)
    has = f"a list of {len(place)}" if isinstance(place, list) else "no list"
    raise StudyError(f"{key}: there is no item {step}, only {has}; give a number from 0 on, or the name of one item")


def _spell(steps: tuple[str, ...]) -> str:
    return ".".join(steps).replace(".[", "[")

"""Definition of one metric, and registries of them. Imports quickly, as `metric_names` must."""

from collections.abc import Iterable
from typing import NamedTuple


class Definition(NamedTuple):
    """A metric's name, unit and meaning in one line."""

    name: str
    unit: str
    meaning: str


def register(definitions: Iterable[Definition]) -> dict[str, Definition]:
    """Return definitions by name.

    Raises
    ------
    ValueError
        A name is defined twice.
    """
    registry: dict[str, Definition] = {}
    for definition in definitions:
        if definition.name in registry:
            raise ValueError(f"metric {definition.name} is defined twice")
        registry[definition.name] = definition
    return registry

"""Groups of options: those that belong together are one record, and one parameter of the command."""

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that has the fields of its dataclass parameters as options."""
    parameters = signature(command).parameters.values()
    groups: dict[str, Any] = {one.name: one.annotation for one in parameters if is_dataclass(one.annotation)}
    options = [option for one in parameters for option in _options(one)]

    @wraps(command)
    def parsed(**given: Any) -> None:
        records = {
            name: group(**{field.name: given.pop(field.name) for field in fields(group)})
            for name, group in groups.items()
        }
        command(**given, **records)

    parsed.__signature__ = Signature(options)  # type: ignore[attr-defined]  # typer reads it, and the annotations
    parsed.__annotations__ = {one.name: one.annotation for one in options}
    return parsed


def given(record: Any) -> list[str]:
    """Return the options of a group that differ from their defaults, as they are typed."""
    names = [field.name for field in fields(record) if getattr(record, field.name) != field.default]
    return [f"--{name.replace('_', '-')}" for name in names]


def _options(parameter: Parameter) -> Iterator[Parameter]:
    if not is_dataclass(parameter.annotation):
        yield parameter.replace(kind=Parameter.KEYWORD_ONLY)
        return
    for field in fields(parameter.annotation):
        yield Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)

"""File format that an option names."""

from typing import Any

from luxloop.plugins import FORMATS, PluginError, formats_that
from luxloop.scenarios.errors import InputError


def format_named(option: str, name: str, ability: str) -> Any:
    """Return a format by its name.

    Parameters
    ----------
    option
        Option that names it, for the message.
    name
        Name of its entry point.
    ability
        Function that it needs, one of `luxloop.plugins.ABILITIES`.

    Raises
    ------
    InputError
        There is no such format, or its plug-in cannot be used.
    """
    if name in FORMATS.names():
        try:
            found = FORMATS.load(name)
        except PluginError as error:
            raise InputError(f"{option} {name}: {error}") from error
        if hasattr(found, ability):
            return found
    raise InputError(f"{option} {name}: is none of {', '.join(formats_that(ability))}")

"""Values of command-line options: file formats and ranges of seeds."""

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


SEEDS_MOST = 10_000
"""Largest number of seeds of a command."""


def parse_seeds(text: str, error: type[InputError] = InputError) -> range:
    """Return the seeds of "7", or of "1-6", from the first to the last.

    Raises
    ------
    InputError
        The text is not of this form; of the class `error`.
    """
    first, _, last = text.partition("-")
    last = last or first
    if not all(part.isdecimal() and len(part) < 19 for part in (first, last)) or int(first) > int(last):
        raise error(f"--seeds {text}: give one seed, or the first and the last, e.g. 1-6")
    if int(last) - int(first) >= SEEDS_MOST:
        raise error(f"--seeds {text}: more than {SEEDS_MOST} seeds; run them in parts")
    return range(int(first), int(last) + 1)

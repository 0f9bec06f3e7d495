"""Range of seeds on the command line."""

from luxloop.scenarios.errors import InputError

MOST = 10_000
"""Largest number of seeds of a command."""


def parse(text: str, error: type[InputError] = InputError) -> range:
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
    if int(last) - int(first) >= MOST:
        raise error(f"--seeds {text}: more than {MOST} seeds; run them in parts")
    return range(int(first), int(last) + 1)

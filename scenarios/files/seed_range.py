"""Range of seeds on the command line."""

from scenarios.errors import InputError


def parse(text: str, error: type[InputError] = InputError) -> range:
    """Return the seeds of "7", or of "1-6", from the first to the last.

    Raises
    ------
    InputError
        The text is not of this form; of the class `error`.
    """
    first, _, last = text.partition("-")
    if not all(part.isdecimal() and len(part) < 19 for part in (first, last or first)) or int(first) > int(
        last or first
    ):
        raise error(f"--seeds {text}: give one seed, or the first and the last, e.g. 1-6")
    return range(int(first), int(last or first) + 1)

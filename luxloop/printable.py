"""Text for a terminal: names in files of strangers may hold escape sequences, which a terminal would obey."""

import os
import sys
from typing import TextIO


def printable(text: str) -> str:
    """Return text with control characters, marks of direction and the like as Python escapes them; lines stay lines."""
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() or letter == "\n" else _escaped(letter) for letter in text)


def _escaped(letter: str) -> str:
    return letter.encode("unicode_escape").decode("ascii")


def print_text(text: str, file: TextIO | None = None, *, end: str = "\n", flush: bool = False) -> None:
    """Print printable text on standard output, or on another stream."""
    print(printable(text), file=file or sys.stdout, end=end, flush=flush)


def is_terminal(stream: TextIO) -> bool:
    """Return True if a stream is a terminal, or shall be treated as one."""
    return bool(os.environ.get("FORCE_COLOR")) or stream.isatty()

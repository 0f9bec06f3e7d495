"""Conversion of SUMO's errors to one line that names the file and the remedy."""

import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from luxloop.sim.sumo.input_checks import input_files, text_of

_REMEDIES = (
    (r"The edge .* is not known", "name an edge of the net"),
    (r"No connection between", "name edges that are connected one to the next"),
    (r"has no valid route", "name edges that are connected one to the next"),
    (r"The vehicle type .* is not known", "define the vType before the vehicle, in this file or an earlier one"),
    (r"The route .* is not known", "define the route before the vehicle, in this file or an earlier one"),
    (r"The lane .* is not known", "name a lane of the net, as <edge>_<index>"),
    (
        r"The (busStop|trainStop|containerStop|parkingArea|chargingStation|overheadWireSegment) .* is not known",
        "list the file that defines it under additional",
    ),
    (r"The vehicle class .* is not known", "use a vehicle class of SUMO, such as passenger or bus"),
    (r"Another vehicle with the id", "use unique ids, and list each route file once"),
    (r"Could not build output file", "create the folder of the output file"),
    (r"The end time should be after the begin time", "lower begin_s, or set options.end"),
    (r"geo-conversion", "write x and y of the net, or import the net with its projection"),
)
"""Remedies for the most common errors, by pattern."""


@contextmanager
def captured_stderr() -> Iterator[BinaryIO]:
    """Redirect the process's stderr, which SUMO's C++ code writes to, into a temporary file."""
    sys.stderr.flush()
    terminal = os.dup(2)
    try:
        with tempfile.TemporaryFile() as captured:
            os.dup2(captured.fileno(), 2)
            try:
                yield captured
            finally:
                os.dup2(terminal, 2)
    finally:
        os.close(terminal)


def one_line(message: str, command: Sequence[str] = ()) -> str:
    """Return SUMO's first error, which may span lines, as one line.

    If exactly one of the input files in `command` contains all the names in the error, its path is prepended. A known
    remedy is appended.
    """
    first = " ".join(message.strip().removeprefix("Error:").split("Error:")[0].split()).rstrip(".")
    remedy = next((f"; {remedy}" for pattern, remedy in _REMEDIES if re.search(pattern, first)), "")
    offending = _offending_file(first, input_files(command))
    return f"{offending}: {first}{remedy}" if offending else f"{first}{remedy}"


def _offending_file(message: str, paths: list[Path]) -> Path | None:
    """Return the only file that contains all names quoted in a message, or None if the message names a file itself."""
    names = re.findall(r"'([^']+)'", message)
    if not names or any(path.name in message for path in paths):
        return None
    holding = [path for path in paths if _holds(path, names)]
    return holding[0] if len(holding) == 1 else None


def _holds(path: Path, names: list[str]) -> bool:
    text = text_of(path)
    return all(re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text) for name in names)

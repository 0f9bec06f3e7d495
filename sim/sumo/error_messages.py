"""What SUMO complains of, in one line that names the file and the remedy."""

import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from sim.sumo.input_checks import input_files, text_of

_REMEDIES = (
    (r"The edge .* is not known", "name an edge of the net"),
    (r"No connection between", "name edges that are connected one to the next"),
    (r"has no valid route", "name edges that are connected one to the next"),
    (r"The vehicle type .* is not known", "define the vType before the vehicle, in this file or in one listed earlier"),
    (r"The route .* is not known", "define the route before the vehicle, in this file or in one listed earlier"),
    (r"The lane .* is not known", "name a lane of the net, as <edge>_<index>"),
    (r"The vehicle class .* is not known", "write a class of SUMO's, as passenger or bus"),
    (r"Another vehicle with the id", "give it an id of its own, and list each route file once"),
    (r"Could not build output file", "make the folder that the file is to lie in"),
    (r"The end time should be after the begin time", "lower begin_s, or set options.end"),
    (r"geo-conversion", "write x and y of the net, or import the net with its projection"),
)
"""What to do about the complaints that are commonest."""


@contextmanager
def captured_stderr() -> Iterator[BinaryIO]:
    """Divert the process's stderr, where SUMO's C++ side writes, into a temporary file."""
    sys.stderr.flush()
    terminal = os.dup(2)
    try:
        with tempfile.TemporaryFile() as said:
            os.dup2(said.fileno(), 2)
            try:
                yield said
            finally:
                os.dup2(terminal, 2)
    finally:
        os.close(terminal)


def one_line(complaint: str, command: Sequence[str] = ()) -> str:
    """Return SUMO's first error, which may span lines, as one line.

    Of the input files that `command` names, the one that alone holds all the names in the error goes before it; a
    remedy follows where one is known.
    """
    first = " ".join(complaint.strip().removeprefix("Error:").split("Error:")[0].split()).rstrip(".")
    remedy = next((f"; {remedy}" for pattern, remedy in _REMEDIES if re.search(pattern, first)), "")
    culprit = _culprit(first, input_files(command))
    return f"{culprit}: {first}{remedy}" if culprit else f"{first}{remedy}"


def _culprit(complaint: str, paths: list[Path]) -> Path | None:
    """Return the one file that holds all the names quoted in a complaint, where the complaint names none itself."""
    names = re.findall(r"'([^']+)'", complaint)
    if not names or any(path.name in complaint for path in paths):
        return None
    holding = [path for path in paths if _holds(path, names)]
    return holding[0] if len(holding) == 1 else None


def _holds(path: Path, names: list[str]) -> bool:
    text = text_of(path)
    return all(re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text) for name in names)

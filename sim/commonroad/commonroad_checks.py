"""Checks of the numbers of a CommonRoad file, before commonroad-io reads it.

commonroad-io subtracts full turns from an angle one by one, so that a large one takes for ever, and it computes with
numbers that are not finite. Road users that stand get a sample in every time step between the first and the last.
"""

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

from luxloop.sim.input_files import NOT_XML
from luxloop.sim.source import TrafficInputError

LARGEST = 1e9
"""Absolute value of any number, in any unit."""
LARGEST_ANGLE = 1e3
"""[rad] Absolute value of orientations."""
MOST_STEPS = 100_000
"""Time steps of a file; at 0.1 s, they last almost three hours."""
ANGLES = frozenset({"orientation", "hitchAngle", "yawRate", "slipAngle", "steeringAngle"})
_NAMES = frozenset({"id", "type", "ref", "geoNameId", "virtual", "additionalValue"})
"""Elements whose text is no quantity."""


def require_plausible_numbers(path: Path) -> None:
    """Check all numbers of a file.

    Raises
    ------
    TrafficInputError
        A number is not finite or too large, or there are too many time steps.
    """
    steps: list[float] = []
    for names, text in _texts(path):
        number = _number(text)
        if number is None or _NAMES.intersection(names):
            continue
        limit = LARGEST_ANGLE if ANGLES.intersection(names) else MOST_STEPS if "time" in names else LARGEST
        if not abs(number) <= limit:
            raise TrafficInputError(
                f"<{names[-1]}> of <{names[-2] if len(names) > 1 else '?'}> = {text[:40]}: "
                f"should be a number within {limit:g}; correct the file"
            )
        if "time" in names:
            steps.append(number)
    if steps and max(steps) - min(steps) > MOST_STEPS:
        raise TrafficInputError(f"has more than {MOST_STEPS} time steps; cut it into parts")


def _texts(path: Path) -> Iterator[tuple[list[str], str]]:
    """Yield the text of each element and attribute, with the names of the elements around it."""
    names: list[str] = []
    try:
        for event, element in ET.iterparse(path, events=("start", "end")):
            if event == "start":
                names.append(element.tag)
                yield from (([element.tag, name], value) for name, value in element.attrib.items())
            else:
                yield names, (element.text or "").strip()
                names.pop()
                element.clear()
    except NOT_XML as error:
        raise TrafficInputError(f"not a complete XML file: {error}") from error


def _number(text: str) -> float | None:
    """Return the number of a text, None if it is none; nan becomes inf, which is outside every limit."""
    try:
        number = float(text)
    except ValueError:
        return None
    return math.inf if math.isnan(number) else number

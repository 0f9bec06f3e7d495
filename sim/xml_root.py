"""Root element of an XML file that may be compressed."""

import xml.etree.ElementTree as ET
from pathlib import Path

from luxloop.sim.compressed import DAMAGED, open_detected
from luxloop.sim.source import TrafficInputError

NOT_XML = (ET.ParseError, LookupError, ValueError, *DAMAGED)
"""Errors of files that are not XML. Unknown encodings raise LookupError, multi-byte ones ValueError."""


def root_element(path: Path) -> ET.Element:
    """Return the root element of an XML file, without its children.

    Raises
    ------
    TrafficInputError
        It is not XML. The message does not name the file.
    """
    try:
        with open_detected(path) as stream:
            root: ET.Element = next(ET.iterparse(stream, events=("start",)))[1]
    except NOT_XML as error:
        raise TrafficInputError(f"not valid XML: {error}") from error
    return root

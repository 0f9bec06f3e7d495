"""Reader of recordings in any supported file format."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from luxloop.sim.missing_file import missing_file
from luxloop.sim.replay import commonroad, fcd
from luxloop.sim.replay.plausible import require_plausible
from luxloop.sim.replay.recording import Recording, ReplayType
from luxloop.sim.replay.track_tables import read_table
from luxloop.sim.source import TrafficInputError
from luxloop.sim.xml_root import root_element

Reader = Callable[[Path, Mapping[str, ReplayType]], Recording]

XML_READERS: dict[str, Reader] = {
    fcd.ROOT: fcd.read_fcd,
    commonroad.ROOT: commonroad.read_commonroad,
}
"""Readers by root element."""


def read_recording(path: Path, types: Mapping[str, ReplayType]) -> Recording:
    """Read a recording.

    Parameters
    ----------
    path
        Path of the file: XML by its suffix, else a table.
    types
        Meaning of the file's names for types of road users.

    Raises
    ------
    TrafficInputError
        The file is missing or invalid. The message does not name the file.
    """
    if not os.path.isfile(path):  # noqa: PTH113  Path.is_file raises for a name that is too long
        raise TrafficInputError(missing_file(path))
    reader = _xml_reader(path) if path.name.endswith((".xml", ".xml.gz")) else read_table
    recording = reader(path, types)
    require_plausible(recording)
    return recording


def _xml_reader(path: Path) -> Reader:
    root = root_element(path).tag
    if root not in XML_READERS:
        raise TrafficInputError(f"its root is <{root}>; it should be one of {', '.join(XML_READERS)}")
    return XML_READERS[root]

"""Reader of recordings in any supported file format."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

from luxloop.plugins import formats_that
from luxloop.sim.input_files import missing_file, root_element
from luxloop.sim.replay import fcd
from luxloop.sim.replay.recording import Recording, ReplayType
from luxloop.sim.replay.recording_checks import require_plausible
from luxloop.sim.replay.track_tables import read_table
from luxloop.sim.source import TrafficInputError

Reader = Callable[[Path, Mapping[str, ReplayType]], Recording]


class TrafficFormat(Protocol):
    """XML format of recorded traffic, a plug-in of the group `luxloop.formats`."""

    TRAFFIC_ROOT: str
    """Name of the root element."""

    def read_traffic(self, path: Path, types: Mapping[str, ReplayType]) -> Recording:
        """Read a recording. See `read_recording`."""
        ...


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


def recording_roots() -> list[str]:
    """Return the root elements of recordings in XML."""
    return list(_xml_readers())


def _xml_reader(path: Path) -> Reader:
    root = root_element(path).tag
    if root == fcd.ROOT:
        return fcd.read_fcd
    readers = _xml_readers()
    if root not in readers:
        raise TrafficInputError(f"its root is <{root}>; it should be one of {', '.join(readers)}")
    return readers[root]


def _xml_readers() -> dict[str, Reader]:
    """Return the readers by root element: of SUMO's floating car data, and of plug-ins."""
    formats: Mapping[str, TrafficFormat] = formats_that("read_traffic")
    return {fcd.ROOT: fcd.read_fcd, **{known.TRAFFIC_ROOT: known.read_traffic for known in formats.values()}}

"""Format `osi`: ASAM OSI 3 traces in MCAP, exported and read back."""

from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.exchange.file_formats import Role

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable
    from luxloop.scenarios.offline.recorded_scans import RecordedRun

BOX_SUFFIXES = ()
EXTRA = "osi"
"""Extra of luxloop that installs the packages of this format."""


def shows_boxes(_path: Path, head: bytes) -> bool:
    """Return True for MCAP with the metadata of a trace, with which OSI's libraries begin."""
    return head.startswith(b"\x89MCAP") and b"net.asam.osi.trace" in head


def read_boxes(path: Path, role: Role) -> "list[BoxTable]":
    """Return the boxes of a trace. See `BoxFormat`."""
    from luxloop.scenarios.exchange.osi import trace_boxes

    return trace_boxes.read(path, role)


def export(run: "RecordedRun", folder: Path) -> None:
    """Write a run as a trace. See `RunFormat`."""
    from luxloop.scenarios.exchange.osi import trace_export

    trace_export.export(run, folder)

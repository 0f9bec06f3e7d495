"""Format `csv`: boxes in a text file of comma-separated values."""

from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.exchange.file_formats import Role, first_line

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable

BOX_SUFFIXES = (".csv",)


def shows_boxes(_path: Path, head: bytes) -> bool:
    """Return True for a text whose first line has a comma."""
    return b"," in first_line(head)


def read_boxes(path: Path, _role: Role) -> "list[BoxTable]":
    """Return the boxes of a file. See `BoxFormat`."""
    from luxloop.scenarios.exchange import tabular_boxes

    return tabular_boxes.read(path)

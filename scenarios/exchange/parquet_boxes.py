"""Format `parquet`: boxes in a Parquet file."""

from pathlib import Path
from typing import TYPE_CHECKING

from luxloop.scenarios.exchange.file_formats import Role

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable

BOX_SUFFIXES = (".parquet",)


def shows_boxes(_path: Path, head: bytes) -> bool:
    """Return True for a file that begins with Parquet's magic number."""
    return head.startswith(b"PAR1")


def read_boxes(path: Path, _role: Role) -> "list[BoxTable]":
    """Return the boxes of a file. See `BoxFormat`."""
    from luxloop.scenarios.exchange import tabular_boxes

    return tabular_boxes.read(path, parquet=True)

"""Format `laps`: text files of boxes with the lines `frame; id; x; y; heading; length; width` in m and degrees.

The module is the plug-in: `luxloop grade` calls its functions, see `luxloop.scenarios.exchange.file_formats.BoxFormat`.
"""

from pathlib import Path

import numpy as np

from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import ANY_AXES, BoxTable, checked

BOX_SUFFIXES = (".laps",)
HEAD = "# laps 1"
FIELDS = 7


def shows_boxes(_path: Path, head: bytes) -> bool:
    """Return True for a file that begins with the head of the format."""
    return head.startswith(HEAD.encode())


def read_boxes(path: Path, _role: str) -> list[BoxTable]:
    """Return the boxes of a file, which has the same form for the truth and for tracks."""
    lines = path.read_text(encoding="utf-8").splitlines()[1:]
    rows = [[word.strip() for word in line.split(";")] for line in lines]
    try:
        numbers = np.array([row[:1] + row[2:] for row in rows], np.float64).reshape(-1, FIELDS - 1)
    except ValueError as error:
        raise TracksError(f"{path}: {error}; give lines of {FIELDS} fields: {FIELDS - 1} numbers and an id") from error
    table = BoxTable(
        source=path,
        axes=ANY_AXES,
        id=np.array([row[1] for row in rows], np.str_),
        frame=numbers[:, 0].astype(np.int64),
        boxes=np.column_stack([numbers[:, 1:3], np.radians(numbers[:, 3]), numbers[:, 4:]]),
    )
    return [checked(table, lambda row: f"line {row + 2}")]

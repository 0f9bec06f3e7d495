"""Formats of files with boxes, recognised by content and else by the ending of the name."""

import codecs
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol

from luxloop.plugins import formats_that
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.files.input_file import require_plain
from luxloop.scenarios.files.option_values import format_named

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable


Role = Literal["truth", "tracks"]


HEAD_BYTES = 2048


class BoxFormat(Protocol):
    """Format of true boxes or tracks, a plug-in of the group `luxloop.formats`."""

    BOX_SUFFIXES: tuple[str, ...]
    """Endings of names, such as ".csv", of files whose content shows no format."""

    def shows_boxes(self, path: Path, head: bytes) -> bool:
        """Return True if a file, by its first `HEAD_BYTES`, or a folder (with an empty head) is of this format."""
        ...

    def read_boxes(self, path: Path, role: Role) -> "list[BoxTable]":
        """Return the boxes of a file, once for each frame of reference that it has.

        Raises
        ------
        TracksError
            The file cannot be read, or is not valid. The message names the file, the row, the value and the remedy.
        """
        ...


def recognise(path: Path) -> str:
    """Return the name of the format of a file or folder.

    Raises
    ------
    TracksError
        The file cannot be read, or is of no known format or of several.
    """
    formats: dict[str, BoxFormat] = formats_that("read_boxes")
    is_folder = path.is_dir()
    head = b"" if is_folder else _head(path)
    found = [name for name, known in formats.items() if known.shows_boxes(path, head)]
    if not found and not is_folder:
        found = [name for name, known in formats.items() if path.suffix.lower() in known.BOX_SUFFIXES]
    if len(found) == 1:
        return found[0]
    what = f"may be of the formats {', '.join(found)}" if found else "no known format"
    if is_folder and not found:
        raise TracksError(f"{path}: a folder of {what} of {', '.join(formats)}; give the file with the boxes")
    raise TracksError(f"{path}: {what}; name it with --truth-format or --tracks-format")


def read(path: Path, role: Role, format_name: str | None = None, *, image: bool = False) -> "list[BoxTable]":
    """Return the boxes of a file, once for each frame of reference on the ground, or those in the image.

    Raises
    ------
    TracksError
        The file cannot be read, is not valid, or has no such boxes.
    """
    from luxloop.scenarios.exchange.box_table import IMAGE_AXES

    known: BoxFormat = format_named(f"--{role}-format", format_name or recognise(path), "read_boxes")
    found = [table for table in known.read_boxes(path, role) if (table.axes == IMAGE_AXES) == image]
    if not found:
        lacks = (
            "boxes in the image, which --kitti grades" if image else "3D boxes; --kitti CLASS grades those in the image"
        )
        raise TracksError(f"{path}: has no {lacks}")
    return found


def is_text(head: bytes) -> bool:
    """Return True for UTF-8 without NUL; the last character of a longer file may be cut off."""
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head, final=len(head) < HEAD_BYTES)
    except UnicodeDecodeError:
        return False
    return b"\0" not in head


def first_line(head: bytes) -> bytes:
    """Return the first line of a text that is not JSON; empty for other files."""
    words = head.lstrip()
    return words.split(b"\n", 1)[0] if is_text(head) and not is_json(head) else b""


def is_json(head: bytes) -> bool:
    """Return True for a text that begins as JSON does."""
    return is_text(head) and head.lstrip()[:1] in (b"{", b"[")


def _head(path: Path) -> bytes:
    require_plain(path)
    try:
        with path.open("rb") as stream:
            return stream.read(HEAD_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise TracksError(f"{path}: cannot be read ({reason}); give an existing file") from error

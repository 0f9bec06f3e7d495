"""Formats of files with boxes, recognised by content and else by the ending of the name."""

import codecs
from pathlib import Path
from typing import Literal, get_args

from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import BoxTable
from luxloop.scenarios.exchange.file_role import Role

Format = Literal["csv", "parquet", "kitti", "nuscenes", "mcap", "osi"]
FORMATS: tuple[Format, ...] = get_args(Format)
ENDINGS: dict[str, Format] = {
    ".csv": "csv", ".parquet": "parquet", ".txt": "kitti", ".json": "nuscenes", ".mcap": "mcap"
}  # fmt: skip
HEAD_BYTES = 2048
OSI_METADATA = b"net.asam.osi.trace"
"""Name of the metadata record that makes an MCAP file an OSI trace; traces of OSI's libraries start with it."""
KITTI_FIELDS = 17


def recognise(path: Path) -> Format:
    """Return the format of a file, or of a folder of nuScenes tables or KITTI sequences.

    Raises
    ------
    TracksError
        The file cannot be read, or is of no known format.
    """
    if path.is_dir():
        return _of_folder(path)
    try:
        with path.open("rb") as stream:
            head = stream.read(HEAD_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise TracksError(f"{path}: cannot be read ({reason}); give an existing file") from error
    found = _of_content(head) or ENDINGS.get(path.suffix.lower())
    if found is None:
        raise TracksError(f"{path}: no known format; name it with --truth-format or --tracks-format")
    return found


def read(path: Path, role: Role, file_format: Format | None = None) -> list[BoxTable]:
    """Return the boxes of a file, once for each frame of reference that it has.

    Raises
    ------
    TracksError
        The file cannot be read, or is not valid.
    """
    file_format = file_format or recognise(path)
    if file_format == "kitti":
        from luxloop.scenarios.exchange import kitti_folder, kitti_labels

        return [kitti_labels.read(kitti_folder.sequence(path, role) if path.is_dir() else path)]
    if file_format == "nuscenes":
        from luxloop.scenarios.exchange import nuscenes_results, nuscenes_tables

        return [nuscenes_tables.read(path) if path.is_dir() else nuscenes_results.read(path)]
    if file_format == "osi":
        from luxloop.scenarios.exchange.osi import trace_boxes

        return trace_boxes.read(path, role)
    if file_format == "mcap":
        from luxloop.scenarios.exchange import mcap_boxes

        return mcap_boxes.read(path, role)
    from luxloop.scenarios.exchange import tabular_boxes

    return tabular_boxes.read(path, parquet=file_format == "parquet")


def _of_folder(path: Path) -> Format:
    from luxloop.scenarios.exchange import kitti_folder, nuscenes_tables

    if nuscenes_tables.folder_of_tables(path):
        return "nuscenes"
    if kitti_folder.is_kitti(path):
        return "kitti"
    raise TracksError(
        f"{path}: a folder without {nuscenes_tables.ANNOTATIONS} of nuScenes and without "
        f"{kitti_folder.LABELS[0]} of KITTI; give the file with the boxes"
    )


def _of_content(head: bytes) -> Format | None:
    """Return the format that the first bytes show, or None."""
    if head.startswith(b"PAR1"):
        return "parquet"
    if head.startswith(b"\x89MCAP"):
        return "osi" if OSI_METADATA in head else "mcap"
    if not _is_text(head):
        return None  # a comma is in many binary files, too
    if head.lstrip()[:1] in (b"{", b"["):
        return "nuscenes"
    line = head.lstrip().split(b"\n", 1)[0]
    if b"," in line:
        return "csv"
    words = line.split()
    return "kitti" if len(words) >= KITTI_FIELDS and words[0].lstrip(b"-").isdigit() else None


def _is_text(head: bytes) -> bool:
    """Return True for UTF-8 without NUL; the last character of a longer file may be cut off."""
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head, final=len(head) < HEAD_BYTES)
    except UnicodeDecodeError:
        return False
    return b"\0" not in head

"""Formats of files with boxes, recognised by content and else by the ending of the name."""

import codecs
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from scenarios.arrays import Bools
from scenarios.errors import TracksError
from scenarios.exchange.box_table import ANY_AXES, EGO_AXES, BoxTable
from scenarios.exchange.file_role import Role

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
        from scenarios.exchange import kitti_folder, kitti_labels

        return [kitti_labels.read(kitti_folder.sequence(path, role) if path.is_dir() else path)]
    if file_format == "nuscenes":
        from scenarios.exchange import nuscenes_results, nuscenes_tables

        return [nuscenes_tables.read(path) if path.is_dir() else nuscenes_results.read(path)]
    if file_format == "osi":
        from scenarios.exchange.osi import trace_boxes

        return trace_boxes.read(path, role)
    if file_format == "mcap":
        from scenarios.exchange import mcap_boxes

        return mcap_boxes.read(path, role)
    from scenarios.exchange import tabular_boxes

    return tabular_boxes.read(path, parquet=file_format == "parquet")


def in_common_axes(truth: list[BoxTable], tracks: list[BoxTable]) -> tuple[BoxTable, BoxTable]:
    """Return the first tables of both files in the same frame of reference.

    Raises
    ------
    TracksError
        There is none.
    """
    pairs = [(a, b) for a in truth for b in tracks if ANY_AXES in (a.axes, b.axes) or a.axes == b.axes]
    if not pairs:
        there, here = (" and ".join(table.axes for table in tables) for tables in (truth, tracks))
        raise TracksError(
            f"{tracks[0].source}: its positions are in {here} axes, those of {truth[0].source} in {there} axes; "
            "give both files in the same frame of reference"
        )
    return min(pairs, key=lambda pair: pair[0].axes != pair[1].axes)


def about_the_ego(tables: list[BoxTable]) -> list[BoxTable]:
    """Return the tables whose axes start at the ego.

    Raises
    ------
    TracksError
        There is none, so the distances from the ego are unknown.
    """
    found = [table for table in tables if table.axes in EGO_AXES]
    if not found:
        axes = " and ".join(table.axes or "unnamed" for table in tables)
        raise TracksError(
            f"{tables[0].source}: its positions are in {axes} axes, so distances from the ego are unknown; "
            "give positions in the ego frame (x_ego_m), or --points-min instead of --range-max"
        )
    return found


def of_classes(truth: BoxTable, tracks: BoxTable, classes: list[str]) -> tuple[BoxTable, BoxTable]:
    """Return the boxes of some classes; tracks without classes are all kept.

    Raises
    ------
    TracksError
        The truth has no classes, or not these.
    """
    wanted = [name.strip().lower() for name in classes]
    if truth.kind is None:
        raise TracksError(f"{truth.source}: has no classes; leave --classes out")
    known = sorted(set(truth.kind.tolist()))
    missing = [name for name in wanted if name not in known]
    if missing:
        raise TracksError(f"{truth.source}: --classes {missing[0]}: not in the file; it has {', '.join(known)[:300]}")
    kept = [table if table.kind is None else table.select(_is_among(table, wanted)) for table in (truth, tracks)]
    return kept[0], kept[1]


def _is_among(table: BoxTable, names: list[str]) -> Bools:
    found: Bools = np.isin(table.kind, names)  # type: ignore[arg-type]
    return found


def _of_folder(path: Path) -> Format:
    from scenarios.exchange import kitti_folder, nuscenes_tables

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

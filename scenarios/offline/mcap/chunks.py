"""Size of the chunks of MCAP files before they are expanded: a few kilobytes may be gigabytes of equal bytes."""

import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import InputError
from luxloop.sim.input_files import ALWAYS_BYTES, FACTOR

HEADER = struct.Struct("<xQQQQII")
"""Of a chunk: opcode, length of the record, first and last time, size when expanded, its CRC, length of the name of the
compression (specification of MCAP, version 0)."""
FRAME_BYTES = 18
"""Longest header of a frame of Zstandard (RFC 8878), which may state a size of its own."""


def require_chunks(path: Path) -> None:
    """Check that no chunk of a file expands to more than `FACTOR` times its size.

    Raises
    ------
    InputError
        A chunk does.
    Exception
        Those of the package mcap for a file that is damaged.
    """
    from mcap.reader import make_reader

    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    require_sizes(path, summary.chunk_indexes if summary else ())


def require_sizes(path: Path, indexes: Iterable[Any]) -> None:
    """Check the chunks of some `mcap.records.ChunkIndex`; errors as `require_chunks`."""
    with path.open("rb") as file:
        for index in indexes:
            file.seek(index.chunk_start_offset)
            expanded = max(index.uncompressed_size, _expanded(file.read(HEADER.size + 64)))
            if expanded > max(ALWAYS_BYTES, FACTOR * index.compressed_size):
                raise InputError(
                    f"{path}: a chunk expands to {expanded:.3g} bytes, more than {FACTOR} times its size; write the "
                    "recording again without compression"
                )


def _expanded(head: bytes) -> int:
    """Return the size that the begin of a chunk states, or that of its frame if that is larger."""
    import zstandard

    *_, expanded, _, name = HEADER.unpack_from(head)
    at = HEADER.size + name
    if head[HEADER.size : at] != b"zstd":
        return int(expanded)  # LZ4 expands to 255 times its size at most
    frame = head[at + 8 : at + 8 + FRAME_BYTES]
    return max(int(expanded), zstandard.frame_content_size(frame))

"""Size of the chunks of MCAP files before they are expanded: a few kilobytes may be gigabytes of equal bytes."""

import struct
from pathlib import Path
from typing import Any

from luxloop.scenarios.errors import InputError
from luxloop.sim.compressed import ALWAYS_BYTES, FACTOR

HEADER = struct.Struct("<xQQQQII")
"""Of a chunk: opcode, length of the record, first and last time, size when expanded, its CRC, length of the name of the
compression (specification of MCAP, version 0)."""
FRAME_BYTES = 18
"""Longest header of a frame of Zstandard (RFC 8878), which may state a size of its own."""


def require_chunks(path: Path, summary: Any) -> None:
    """Check that no chunk of a file expands to more than `FACTOR` times its size.

    Parameters
    ----------
    path
        The file.
    summary
        Its summary, as the package mcap reads it.

    Raises
    ------
    InputError
        A chunk does.
    """
    with path.open("rb") as file:
        for index in summary.chunk_indexes if summary else ():
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

"""Format `pcd`: files of the Point Cloud Library: ascii, binary and binary_compressed, version 0.7 and before.

Compressed points are LZF, a sequence of blocks. A control byte below 32 is followed by that many literal bytes plus
one. Another one holds in its upper 3 bits the length of a copy minus 2 (7 continues in the next byte), and in its lower
5 bits, with one more byte, the distance back minus 1 (M. Lehmann, LibLZF).

The package pypcd4 (1.5.1) is not used: it reads a truncated file as a shorter one, and rejects headers without COUNT or
POINTS, which older versions of the format have.
"""

import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.point_files import PointFiles

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions


LITERALS = 32
LONG = 7


def decompress(packed: bytes, size: int) -> bytes:
    """Return the `size` bytes that `packed` holds.

    Raises
    ------
    ValueError
        The data are damaged.
    """
    out, at = bytearray(), 0
    while at < len(packed):
        control = packed[at]
        at += 1
        if control < LITERALS:
            out += packed[at : at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == LONG:
            length += _byte(packed, at)
            at += 1
        start = len(out) - ((control & 31) << 8) - _byte(packed, at) - 1
        at += 1
        if start < 0:
            raise ValueError("LZF data refer to bytes before their beginning")
        _copy(out, start, length + 2)
    if len(out) != size:
        raise ValueError(f"LZF data hold {len(out)} bytes, not {size}")
    return bytes(out)


def _byte(packed: bytes, at: int) -> int:
    if at >= len(packed):
        raise ValueError("LZF data end within a block")
    return packed[at]


def _copy(out: bytearray, start: int, length: int) -> None:
    """Append `length` bytes from `start` on, which may be among those that are appended."""
    distance = len(out) - start
    if distance >= length:
        out += out[start : start + length]
    else:
        piece = bytes(out[start:])
        out += (piece * (length // distance + 1))[:length]


RECORDING_SUFFIXES = (".pcd",)
HEADER_MAX = 65_536
"""Bytes searched for the end of the header."""
LAST_LINE = re.compile(rb"^DATA\b.*\n", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class PcdHeader:
    """Header of a PCD file."""

    layout: np.dtype[np.void]
    """Fields of a point."""
    points: int
    data: str
    """`ascii`, `binary` or `binary_compressed`."""
    size: int
    """Bytes of the header."""


def open_recording(paths: list[Path], options: "ReadOptions") -> PointFiles:
    """Take files as sweeps of a constant rate. See `RecordingFormat`."""
    return PointFiles(paths, read_pcd, "PCD", 1.0 / options.rate_hz, options.time_unit_s)


def read_pcd(path: Path) -> npt.NDArray[np.void]:
    """Return the points (N,) of a file, with its fields.

    Raises
    ------
    InputError
        The file is no PCD file, or is truncated.
    """
    content = path.read_bytes()
    header = _header(path, content)
    body = content[header.size :]
    if header.data == "ascii":
        return _ascii(path, body, header)
    if header.data == "binary":
        return np.frombuffer(_exactly(path, body, header), dtype=header.layout)
    return _compressed(path, body, header)


def _header(path: Path, content: bytes) -> PcdHeader:
    last = LAST_LINE.search(content, 0, HEADER_MAX)
    end = last.end() if last else 0
    lines = content[:end].decode("utf-8", errors="replace").splitlines()  # comments may be in any language
    words = {line.split()[0]: line.split()[1:] for line in lines if line.split() and not line.startswith("#")}
    try:
        names, sizes, kinds = words["FIELDS"], words["SIZE"], words["TYPE"]
        counts = words.get("COUNT", ["1"] * len(names))
        points = int(words["POINTS"][0]) if "POINTS" in words else int(words["WIDTH"][0]) * int(words["HEIGHT"][0])
        formats = [
            (name if name != "_" else f"_{place}", f"<{kind.lower()}{size}", (int(count),) if count != "1" else ())
            for place, (name, kind, size, count) in enumerate(zip(names, kinds, sizes, counts, strict=True))
        ]
        layout, data = np.dtype(formats), words["DATA"][0]
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise InputError(f"{path}: not readable as PCD: its header is damaged or missing ({error})") from error
    if data not in ("ascii", "binary", "binary_compressed") or points < 0:
        raise InputError(f"{path}: not readable as PCD: DATA {data}, POINTS {points}; save it as binary")
    return PcdHeader(layout, points, data, end)


def _ascii(path: Path, body: bytes, header: PcdHeader) -> npt.NDArray[np.void]:
    width = sum(int(np.prod(header.layout[name].shape)) for name in header.layout.names or ())
    has_rows = any(line and not line.startswith(b"#") for line in map(bytes.strip, body.splitlines()))
    rows = np.loadtxt(io.BytesIO(body), dtype=np.float64, ndmin=2) if has_rows else np.empty((0, width))
    if rows.shape != (header.points, width):
        raise InputError(f"{path}: has {len(rows)} of {header.points} points; it is truncated, copy it again")
    table = np.zeros(header.points, dtype=header.layout)
    column = 0
    for name in header.layout.names or ():
        shape = header.layout[name].shape
        step = int(np.prod(shape))
        with np.errstate(over="ignore", invalid="ignore"):  # points that are not finite are left out
            table[name] = rows[:, column : column + step].reshape(-1, *shape)
        column += step
    return table


def _exactly(path: Path, body: bytes, header: PcdHeader) -> bytes:
    wanted = header.points * header.layout.itemsize
    if len(body) < wanted:
        raise InputError(f"{path}: holds {len(body)} of {wanted} bytes of points; it is truncated, copy it again")
    return body[:wanted]


def _compressed(path: Path, body: bytes, header: PcdHeader) -> npt.NDArray[np.void]:
    """Return points compressed with LZF, stored field by field."""
    sizes = np.frombuffer(body[:8].ljust(8, b"\0"), dtype="<u4")
    packed, whole = int(sizes[0]), int(sizes[1])
    if len(body) < 8 + packed or whole != header.points * header.layout.itemsize:
        raise InputError(f"{path}: its compressed points are not complete; it is truncated or damaged, copy it again")
    columns = decompress(body[8 : 8 + packed], whole)
    table, at = np.zeros(header.points, dtype=header.layout), 0
    for name in header.layout.names or ():
        field = header.layout[name]
        end = at + header.points * field.itemsize
        table[name] = np.frombuffer(columns[at:end], dtype=field.base).reshape(-1, *field.shape)
        at = end
    return table

"""Streams of LUX scan messages in files.

Messages follow one another, either plain or each after a data header of the network protocol. That header has 24 bytes,
big-endian: magic word 0xAFFEC0C2, size of the previous message, size of the message, a reserved byte, device, type,
and NTP time (SICK, Ethernet data protocol of the LD-MRS, 8014493). Messages of other types are skipped.
"""

import struct
from collections.abc import Iterable, Iterator
from io import BufferedReader
from pathlib import Path

from luxloop.sensor_model.formats.lux_scan_message import (
    DATA_TYPE,
    HEADER_BYTES,
    LuxMessage,
    decode,
    encode,
    message_bytes,
)

MAGIC = 0xAFFEC0C2
"""First word of a data header."""

_DATA_HEADER = struct.Struct(">IIIBBHQ")
DATA_HEADER_BYTES = _DATA_HEADER.size
_MAGIC_BYTES = MAGIC.to_bytes(4, "big")


def read_stream(path: Path | str, *, fragment: bool = False) -> Iterator[LuxMessage]:
    """Read the scan messages of a file, one at a time.

    Parameters
    ----------
    fragment
        If True, the last message may lack points at its end.

    Raises
    ------
    ValueError
        The file is empty, cut off, or holds bytes that are not a message; the text names file and offset.
    """
    with Path(path).open("rb") as file:
        found = False
        while start := file.read(4):
            offset = file.tell() - len(start)
            body = _framed_body(file, path, offset) if start == _MAGIC_BYTES else _plain_body(file, path, offset, start)
            if body is None:
                continue
            found = True
            try:
                yield decode(body, fragment=fragment and not file.peek(1))
            except ValueError as error:
                raise ValueError(f"{path}: message at offset {offset}: {error}") from None
        if not found:
            raise ValueError(f"{path}: offset 0: expected a scan message of type 0x{DATA_TYPE:04X}, found none")


def stream_bytes(messages: Iterable[LuxMessage], device: int | None = None) -> Iterator[bytes]:
    """Return the bytes of each message, after a data header of the network protocol if a device number is given."""
    previous = 0
    for message in messages:
        body = encode(message)
        if device is None:
            yield body
            continue
        yield data_header(previous, len(body), device, DATA_TYPE, message.header.end_ntp) + body
        previous = DATA_HEADER_BYTES + len(body)


def data_header(previous: int, size: int, device: int, data_type: int, ntp: int) -> bytes:
    """Return a data header of the network protocol.

    Parameters
    ----------
    previous
        Size of the previous message with its header; 0 for the first.
    size
        Size of the message without the header.
    device
        Number of the device, 0 to 255.
    data_type
        Type of the message.
    ntp
        Time of the message.
    """
    return _DATA_HEADER.pack(MAGIC, previous, size, 0, device, data_type, ntp)


def read_framed(path: Path | str) -> Iterator[tuple[int, bytes]]:
    """Read data type and body of each message of a file, all of which have data headers.

    Raises
    ------
    ValueError
        The file is cut off, or has bytes that are no message; the text names file and offset.
    """
    with Path(path).open("rb") as file:
        offset = 0
        while header := file.read(_DATA_HEADER.size):
            if len(header) < _DATA_HEADER.size or not header.startswith(_MAGIC_BYTES):
                raise ValueError(f"{path}: offset {offset}: expected a data header of {_DATA_HEADER.size} bytes")
            _, _, size, _, _, data_type, _ = _DATA_HEADER.unpack(header)
            body = file.read(size)
            if len(body) < size:
                raise ValueError(f"{path}: offset {offset}: expected {size} bytes after the data header, "
                                 f"found {len(body)}; the file is cut off")  # fmt: skip
            yield data_type, body
            offset += _DATA_HEADER.size + size


def _framed_body(file: BufferedReader, path: Path | str, offset: int) -> bytes | None:
    """Return the body after a data header whose magic word has been read; None for other types of message."""
    header = _MAGIC_BYTES + file.read(_DATA_HEADER.size - len(_MAGIC_BYTES))
    if len(header) < _DATA_HEADER.size:
        raise ValueError(f"{path}: offset {offset}: expected {_DATA_HEADER.size} bytes of data header, "
                         f"found {len(header)}; the file is cut off")  # fmt: skip
    _, _, size, _, _, data_type, _ = _DATA_HEADER.unpack(header)
    body = file.read(size)
    if data_type == DATA_TYPE:
        return body
    if len(body) < size:
        raise ValueError(f"{path}: offset {offset}: expected {size} bytes after the data header of type "
                         f"0x{data_type:04X}, found {len(body)}; the file is cut off")  # fmt: skip
    return None


def _plain_body(file: BufferedReader, path: Path | str, offset: int, start: bytes) -> bytes:
    """Return a message without data header whose first bytes have been read."""
    header = start + file.read(HEADER_BYTES - len(start))
    try:
        return header + file.read(message_bytes(header) - len(header))
    except ValueError as error:
        raise ValueError(f"{path}: message at offset {offset}: {error}") from None

"""LZF decompression, as PCD files use it.

The format is a sequence of blocks. A control byte below 32 is followed by that many literal bytes plus one. Another one
holds in its upper 3 bits the length of a copy minus 2 (7 continues in the next byte), and in its lower 5 bits, with one
more byte, the distance back minus 1 (M. Lehmann, LibLZF).
"""

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

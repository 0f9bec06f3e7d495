"""Scan message 0x2202 of the IBEO LUX and SICK LD-MRS.

A message is a header of 44 bytes and 10 bytes per point, all little-endian (SICK, Ethernet data protocol of the LD-MRS,
8014493). Angles are in ticks of 1/32 degree, left positive; ranges and pulse widths are in cm. `encode` reproduces the
bytes that `decode` read, with the reserved words and the flags whose meaning is not documented.
"""

import struct
from dataclasses import astuple, dataclass

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bytes, Floats

DATA_TYPE = 0x2202
"""Type of the message in the data header of the network protocol."""
HEADER_BYTES, POINT_BYTES = 44, 10
TICKS_PER_TURN = 11520
"""Angle ticks of a full turn, the same for every unit: 32 per degree."""
TICKS_PER_DEG = TICKS_PER_TURN / 360.0
CM_PER_M = 100.0

_HEADER = struct.Struct("<HHHQQHhhHhhhhhhH")
_TICKS_OFFSET, _COUNT_OFFSET = 22, 28  # of these words in the header
_POINT = np.dtype(
    [("id", "u1"), ("flags", "u1"), ("azimuth", "<i2"), ("range", "<u2"), ("width", "<u2"), ("reserved", "<u2")]
)
_NTP_PER_S = 2.0**32


@dataclass(frozen=True, slots=True)
class LuxHeader:
    """Header of a scan message, in the order and the units of the message."""

    scan_number: int
    scanner_status: int
    """Bits for motor, laser and synchronisation."""
    sync_phase: int
    """Delay of the scan relative to the sync signal [409.6 ns]."""
    start_ntp: int
    """Time of the first beam: seconds in the upper, fractions of 2^-32 s in the lower 32 bits."""
    end_ntp: int
    """Time of the last beam."""
    ticks_per_turn: int
    """Always `TICKS_PER_TURN`."""
    start_ticks: int
    """Azimuth of the first beam."""
    end_ticks: int
    """Azimuth of the last beam."""
    points: int
    """Declared number of points."""
    mount_yaw_ticks: int
    mount_pitch_ticks: int
    mount_roll_ticks: int
    mount_x_cm: int
    """Mounting position in the rear-axle frame."""
    mount_y_cm: int
    mount_z_cm: int
    flags: int
    """Bits for ground, dirt and rain labels, and in bit 10 the mirror side."""


@dataclass(frozen=True, slots=True, eq=False)
class LuxMessage:
    """Scan message with N points."""

    header: LuxHeader
    layer: Bytes
    """(N,) 0 to 15; 0 is the lowest."""
    echo: Bytes
    """(N,) 0 to 15; 0 is the nearest echo of its beam."""
    flags: Bytes
    """(N,) bits 0 to 3 as in `luxloop.tracker.scan.PointFlag`."""
    azimuth_ticks: npt.NDArray[np.int16]
    """(N,) in the unit's frame."""
    range_cm: npt.NDArray[np.uint16]
    """(N,)"""
    width_cm: npt.NDArray[np.uint16]
    """(N,) echo pulse width."""
    reserved: npt.NDArray[np.uint16]
    """(N,) the last word of each point."""
    rest: bytes = b""
    """Bytes of a point that a fragment cuts off; empty in a complete message."""

    def __len__(self) -> int:
        return len(self.layer)

    @property
    def complete(self) -> bool:
        """True if all declared points are present."""
        return len(self) == self.header.points

    @property
    def start_s(self) -> float:
        """Time of the first beam on the unit's clock [s]."""
        return self.header.start_ntp / _NTP_PER_S

    @property
    def duration_s(self) -> float:
        """Time from the first to the last beam [s]."""
        return (self.header.end_ntp - self.header.start_ntp) / _NTP_PER_S

    @property
    def time_offset(self) -> Floats:
        """(N,) firing time of each point after the first beam [s]: the mirror turns evenly."""
        swept = self.header.start_ticks - self.header.end_ticks
        rate = self.duration_s / swept if swept else 0.0
        offset: Floats = (self.header.start_ticks - self.azimuth_ticks.astype(np.float64)) * rate
        return offset


def message_bytes(header: bytes) -> int:
    """Return the length of a message by its header: at least `HEADER_BYTES` bytes.

    Raises
    ------
    ValueError
        These bytes are not the start of a scan message.
    """
    if len(header) < HEADER_BYTES:
        raise ValueError(f"offset 0: a scan message starts with {HEADER_BYTES} bytes of header, found {len(header)}")
    (ticks,) = struct.unpack_from("<H", header, _TICKS_OFFSET)
    if ticks != TICKS_PER_TURN:
        raise ValueError(
            f"offset {_TICKS_OFFSET}: a scan message has {TICKS_PER_TURN} angle ticks per turn, found {ticks}; "
            "this is not the start of a 0x2202 message"
        )
    (points,) = struct.unpack_from("<H", header, _COUNT_OFFSET)
    return HEADER_BYTES + POINT_BYTES * int(points)


def decode(data: bytes, *, fragment: bool = False) -> LuxMessage:
    """Decode one message.

    Parameters
    ----------
    fragment
        If True, points may be missing at the end, as in the first packet of a message.

    Raises
    ------
    ValueError
        The bytes are not a message, hold fewer points than declared and are no fragment, or go on after the last one.
    """
    size = message_bytes(data)
    if len(data) > size:
        raise ValueError(f"offset {size}: the message ends here by its number of points, found {len(data) - size} more")
    if len(data) < size and not fragment:
        raise ValueError(
            f"offset {_COUNT_OFFSET}: {(size - HEADER_BYTES) // POINT_BYTES} points declared, expected {size} bytes, "
            f"found {len(data)}; give the whole message, or fragment=True for its first part"
        )
    count = (len(data) - HEADER_BYTES) // POINT_BYTES
    point = np.frombuffer(data, _POINT, count, HEADER_BYTES)
    return LuxMessage(
        header=LuxHeader(*_HEADER.unpack_from(data)),
        layer=point["id"] & np.uint8(0x0F),
        echo=point["id"] >> np.uint8(4),
        flags=point["flags"].copy(),
        azimuth_ticks=point["azimuth"].astype(np.int16),
        range_cm=point["range"].astype(np.uint16),
        width_cm=point["width"].astype(np.uint16),
        reserved=point["reserved"].astype(np.uint16),
        rest=data[HEADER_BYTES + count * POINT_BYTES :],
    )


def encode(message: LuxMessage) -> bytes:
    """Encode a message, or a fragment of one.

    Raises
    ------
    ValueError
        The message has more points than its header declares, or a value does not fit into its field.
    """
    if len(message) > message.header.points:
        raise ValueError(f"points = {message.header.points} in the header; the message has {len(message)}")
    for name in ("layer", "echo"):
        if np.any(getattr(message, name) > 0x0F):
            raise ValueError(f"{name} = {getattr(message, name).max()}: must be 0 to 15")
    try:
        header = _HEADER.pack(*astuple(message.header))
    except struct.error as error:
        raise ValueError(f"header: {error}") from None
    point = np.empty(len(message), _POINT)
    point["id"] = message.layer | (message.echo << 4)
    point["flags"] = message.flags
    point["azimuth"], point["range"] = message.azimuth_ticks, message.range_cm
    point["width"], point["reserved"] = message.width_cm, message.reserved
    return header + point.tobytes() + message.rest

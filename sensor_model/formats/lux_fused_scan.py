"""Fused scan 0x2205 of the IBEO fusion system: the points of all units in the vehicle frame.

A message is a header of 24 bytes, 148 bytes per unit and 28 bytes per point, all big-endian with float32 numbers. The
layout is that of two public drivers: PolySync, `ibeo_lux_4l_driver.h` (protocol FF5.7.4, version 1.38), and
AutonomouStuff, `ibeo_core.cpp`, which also has the fields of the units and the flags. `encode` reproduces the bytes
that `decode` read.
"""

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

DATA_TYPE = 0x2205
"""Type of the message in the data header of the network protocol."""
FUSED, VEHICLE_FRAME = 0x0100, 0x0400
"""Flags of a scan: of several units; coordinates from the rear axle."""
GROUND, DIRT, RAIN, TRANSPARENT = 0x0001, 0x0002, 0x0004, 0x1000
"""Flags of a point."""
LUX = 6
"""Type of a unit."""

UNIT = np.dtype(
    [
        ("device", "u1"), ("type", "u1"), ("scan_number", ">u2"), ("reserved", ">u4"),
        ("start_rad", ">f4"), ("end_rad", ">f4"),
        ("start_ntp", ">u8"), ("end_ntp", ">u8"), ("device_start_ntp", ">u8"), ("device_end_ntp", ">u8"),
        ("rate_hz", ">f4"), ("beam_tilt_rad", ">f4"), ("flags", ">u4"),
        ("yaw_rad", ">f4"), ("pitch_rad", ">f4"), ("roll_rad", ">f4"),
        ("x_m", ">f4"), ("y_m", ">f4"), ("z_m", ">f4"),
        ("resolution", ">f4", (8, 2)),
    ]
)  # fmt: skip
"""Scanner info: poses from the rear axle, and up to 8 sectors with start angle and resolution [rad]."""
POINT = np.dtype(
    [
        ("x_m", ">f4"), ("y_m", ">f4"), ("z_m", ">f4"), ("width_m", ">f4"),
        ("device", "u1"), ("layer", "u1"), ("echo", "u1"), ("reserved", "u1"),
        ("offset_us", ">u4"), ("flags", ">u2"), ("reserved_end", ">u2"),
    ]
)  # fmt: skip
"""Point: position [m], echo width [m], and time after the start of the scan [us]."""
_HEADER = struct.Struct(">QIIHHBHB")


@dataclass(frozen=True, slots=True, eq=False)
class FusedScan:
    """Fused scan."""

    start_ntp: int
    """Time of the first beam: seconds in the upper, fractions of 2^-32 s in the lower 32 bits."""
    duration_us: int
    """Time from the first to the last beam."""
    flags: int
    scan_number: int
    units: npt.NDArray[Any]
    """(U,) of `UNIT`."""
    points: npt.NDArray[Any]
    """(N,) of `POINT`."""
    reserved: tuple[int, int] = (0, 0)
    """Last words of the header."""


def decode(data: bytes) -> FusedScan:
    """Decode one message.

    Raises
    ------
    ValueError
        Its length is not that of its numbers of units and points.
    """
    if len(data) < _HEADER.size:
        raise ValueError(f"offset 0: a fused scan starts with {_HEADER.size} bytes of header, found {len(data)}")
    start, duration, flags, number, points, units, *reserved = _HEADER.unpack_from(data)
    at = _HEADER.size + units * UNIT.itemsize
    size = at + points * POINT.itemsize
    if len(data) != size:
        raise ValueError(
            f"offset 0: {units} units and {points} points declared, expected {size} bytes, found {len(data)}"
        )
    return FusedScan(
        start_ntp=start,
        duration_us=duration,
        flags=flags,
        scan_number=number,
        units=np.frombuffer(data, UNIT, units, _HEADER.size),
        points=np.frombuffer(data, POINT, points, at),
        reserved=(reserved[0], reserved[1]),
    )


def encode(scan: FusedScan) -> bytes:
    """Encode one message.

    Raises
    ------
    ValueError
        A value does not fit into its field.
    """
    try:
        header = _HEADER.pack(
            scan.start_ntp, scan.duration_us, scan.flags, scan.scan_number, len(scan.points), len(scan.units),
            *scan.reserved,
        )  # fmt: skip
    except struct.error as error:
        raise ValueError(f"header: {error}") from None
    return header + scan.units.astype(UNIT).tobytes() + scan.points.astype(POINT).tobytes()

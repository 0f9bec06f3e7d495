"""Object list 0x2280 of the IBEO fusion system.

A message is the middle time of its scan, the number of objects, and per object 168 bytes and its contour of 8 bytes per
point, all big-endian with float32 numbers. The layout is that of two public drivers: PolySync, `ibeo_lux_4l_driver.h`
(protocol FF5.7.4, version 1.38), and AutonomouStuff, `ibeo_core.cpp`. `encode` reproduces the bytes that `decode` read.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

DATA_TYPE = 0x2280
"""Type of the message in the data header of the network protocol."""
NO_CONTOUR = 255
"""Number of contour points that stands for none."""

OBJECT = np.dtype(
    [
        ("id", ">u2"), ("flags", ">u2"), ("age", ">u4"), ("ntp", ">u8"), ("prediction_age", ">u2"),
        ("classification", "u1"), ("classification_quality", "u1"), ("classification_age_ms", ">u4"),
        ("reserved_0", "V16"),
        ("center_m", ">f4", 2), ("center_sigma_m", ">f4", 2), ("size_m", ">f4", 2), ("reserved_1", "V8"),
        ("course_rad", ">f4"), ("course_sigma_rad", ">f4"),
        ("relative_velocity_mps", ">f4", 2), ("relative_velocity_sigma_mps", ">f4", 2),
        ("velocity_mps", ">f4", 2), ("velocity_sigma_mps", ">f4", 2),
        ("reserved_2", "V18"),
        ("contour_points", "u1"), ("closest_point", "u1"),
        ("reference_location", ">u2"), ("reference_m", ">f4", 2), ("reference_sigma_m", ">f4", 2),
        ("reserved_3", "V12"), ("priority", ">u2"), ("reserved_4", "V4"),
    ]
)  # fmt: skip
"""Object: ages in scans; box in the vehicle frame, from the rear axle; velocity relative to the ego and over ground."""
CONTOUR = np.dtype((">f4", 2))
"""Point of a contour, x and y [m]."""
_HEADER = struct.Struct(">QH")


@dataclass(frozen=True, slots=True, eq=False)
class ObjectList:
    """Object list."""

    middle_ntp: int
    """Mean time of the scan: seconds in the upper, fractions of 2^-32 s in the lower 32 bits."""
    objects: npt.NDArray[Any]
    """(N,) of `OBJECT`."""
    contours: Sequence[npt.NDArray[Any]] = field(default=())
    """Contour points (K, 2) of each object [m]; empty if no object has any."""


def decode(data: bytes) -> ObjectList:
    """Decode one message.

    Raises
    ------
    ValueError
        It ends before its last object, or goes on after it.
    """
    if len(data) < _HEADER.size:
        raise ValueError(f"offset 0: an object list starts with {_HEADER.size} bytes of header, found {len(data)}")
    middle, count = _HEADER.unpack_from(data)
    objects, contours, at = [], [], _HEADER.size
    for number in range(count):
        if len(data) < at + OBJECT.itemsize:
            found = len(data) - at
            raise ValueError(f"offset {at}: object {number} of {count} has {OBJECT.itemsize} bytes, found {found}")
        objects.append(np.frombuffer(data, OBJECT, 1, at))
        at += OBJECT.itemsize
        points = _contour_points(objects[-1][0])
        if len(data) < at + points * CONTOUR.itemsize:
            raise ValueError(f"offset {at}: object {number} has {points} contour points, found {len(data) - at} bytes")
        contours.append(np.frombuffer(data, ">f4", 2 * points, at).reshape(points, 2))
        at += points * CONTOUR.itemsize
    if len(data) > at:
        raise ValueError(f"offset {at}: the message ends here by its number of objects, found {len(data) - at} more")
    return ObjectList(middle, np.concatenate(objects) if objects else np.empty(0, OBJECT), contours)


def encode(found: ObjectList) -> bytes:
    """Encode one message.

    Raises
    ------
    ValueError
        A value does not fit into its field, or an object has not as many contour points as it declares.
    """
    try:
        parts = [_HEADER.pack(found.middle_ntp, len(found.objects))]
    except struct.error as error:
        raise ValueError(f"header: {error}") from None
    for number, row in enumerate(found.objects.astype(OBJECT)):
        contour = found.contours[number] if len(found.contours) else np.empty((0, 2))
        if len(contour) != _contour_points(row):
            raise ValueError(f"contour_points = {row['contour_points']}: object {number} has {len(contour)}")
        parts += [row.tobytes(), contour.astype(">f4").tobytes()]
    return b"".join(parts)


def _contour_points(row: npt.NDArray[Any]) -> int:
    points = int(row["contour_points"])
    return 0 if points == NO_CONTOUR else points

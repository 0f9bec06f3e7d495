"""The tracker's input contract: one sweep of all units, as the rig's fusion box delivers it.

Ego frame: origin at the ego's box centre on the ground, x forward, y left, z up.
Odometry frame: fixed to the ground, starts as the ego frame of the first scan.
"""

from dataclasses import dataclass
from enum import IntFlag

import numpy as np
import numpy.typing as npt


class PointFlag(IntFlag):
    """What the unit itself says of a point (IBEO LUX scan 0x2202, flags byte)."""

    TRANSPARENT = 0x01
    """The beam has another echo behind this one."""
    CLUTTER = 0x02
    """It came from the air: rain, spray, dust."""
    GROUND = 0x04
    DIRT = 0x08


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Points of one sweep of the whole rig. No ids: truth never enters the tracker.

    Echoes of one beam follow one another, the nearest first.
    """

    time: float
    """[s] at the frame's clock."""
    ego_pose_odom: npt.NDArray[np.float64]
    """(3,) x [m], y [m], yaw [rad] of the ego frame in the odometry frame."""
    points_ego: npt.NDArray[np.float32]
    """(N, 3) x, y, z in the ego frame of the point's own time [m]."""
    time_offset: npt.NDArray[np.float32]
    """(N,) the point's own time minus `time` [s]."""
    unit: npt.NDArray[np.uint8]
    """(N,) index of the unit in the rig."""
    layer: npt.NDArray[np.uint8]
    """(N,) 0 is the lowest."""
    echo: npt.NDArray[np.uint8]
    """(N,) 0 is the nearest echo of its beam."""
    echo_pulse_width: npt.NDArray[np.float32]
    """(N,) [m]."""
    flags: npt.NDArray[np.uint16]
    """(N,) `PointFlag`."""

    def __len__(self) -> int:
        return len(self.unit)

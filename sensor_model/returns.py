"""Returns of a scan, between ray caster and point cloud: one row per return."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bytes, Floats, Ints
from luxloop.tracker.scan import PointFlag

NOTHING = -1
GROUND = -2
WALL = -3


@dataclass(frozen=True, slots=True, eq=False)
class Returns:
    """N returns, ordered by beam and, within a beam, from near to far."""

    beam: Ints
    """(N,) row of the beam table."""
    range: Floats
    """(N,) leading edge of the echo, without range noise [m]."""
    width: Floats
    """(N,) width of the pulse above the threshold [m]."""
    power: Floats
    """(N,) highest power of the echo: reflectivity x cos(incidence) x gain / range^2 of all its sources [1/m^2]."""
    target: Ints
    """(N,) row of the actor hit, or `GROUND`, `WALL`, `NOTHING`."""
    surface: Ints
    """(N,) plane of `Bodies` on actors, wall of `Walls` on walls, else 0."""
    part: Bytes
    """(N,) `Part`."""
    cause: Bytes
    """(N,) `Cause`."""
    point_body: Floats
    """(N, 2) the point in the frame of its actor, with articulation removed [m]; zero elsewhere."""
    flags: npt.NDArray[np.uint16]
    """(N,) `PointFlag`."""

    def __len__(self) -> int:
        return len(self.beam)

    @property
    def echo(self) -> Bytes:
        """(N,) index of the return in its beam, 0 for the nearest."""
        number, begins = np.arange(len(self.beam)), np.ones(len(self.beam), dtype=np.bool_)
        np.not_equal(self.beam[1:], self.beam[:-1], out=begins[1:])
        return (number - np.maximum.accumulate(np.where(begins, number, 0))).astype(np.uint8)

    @property
    def transparent(self) -> npt.NDArray[np.uint16]:
        """(N,) `PointFlag.TRANSPARENT` if the beam has another echo behind, which is how a LUX detects glass."""
        behind = np.append(self.beam[1:] == self.beam[:-1], np.zeros(min(len(self), 1), dtype=np.bool_))
        return np.where(behind, PointFlag.TRANSPARENT, 0).astype(np.uint16)

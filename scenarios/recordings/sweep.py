"""Contents of a recording, in its own units: sweeps of LIDARs, and poses of bodies."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Floats, Ints

Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """Points of one sweep of one LIDAR, in the sensor's frame (x forward, y left, z up)."""

    time: float
    """[s] on the clock of the recording."""
    unit: int
    """Number of the LIDAR: the position of its topic among the requested ones."""
    points: Floats
    """(N, 3) [m], each at its own time; finite."""
    time_offset: Floats
    """(N,) time of the point minus `time` [s]; 0 where the format has no times."""
    ring: Ints | None = None
    """(N,) number of the ring or layer in the order of the device; None where the format has none."""
    echo: Bytes | None = None
    """(N,) 0 is the nearest echo of its beam; None for first echoes only."""
    echo_pulse_width: Floats | None = None
    """(N,) [m]; None where the format has none."""
    flags: Ints | None = None
    """(N,) `luxloop.tracker.scan.PointFlag`; None where the format has none."""

    def __len__(self) -> int:
        return len(self.points)

    def subset(self, index: npt.NDArray[Any]) -> "Sweep":
        """Return the points of `index`, a mask (N,) or row numbers."""
        optional = (self.ring, self.echo, self.echo_pulse_width, self.flags)
        picked = [None if values is None else values[index] for values in optional]
        return Sweep(self.time, self.unit, self.points[index], self.time_offset[index], *picked)


@dataclass(slots=True)
class PoseList:
    """Poses of one body, in the order of the recording."""

    frame: str = ""
    """Name of the frame in which the poses are given; empty if the recording does not name it."""
    rows: list[tuple[float, float, float, float]] = field(default_factory=list)
    """Time [s], x [m], y [m], yaw [rad] counter-clockwise."""


class RecordingSource(Protocol):
    """An opened recording. It can be read repeatedly."""

    @property
    def count(self) -> int | None:
        """Number of sweeps, for the progress bar; None if it is not known beforehand."""
        ...

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the sweeps in the order of the recording."""
        ...

    def poses(self, name: str) -> PoseList:
        """Return the poses of a topic, or of a transform `TOPIC:PARENT:CHILD`.

        Raises
        ------
        InputError
            The recording has no such poses.
        """
        ...

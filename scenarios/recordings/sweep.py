"""Contents of a recording, in its own units: sweeps of LIDARs, and poses of bodies."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.errors import InputError

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.box_table import BoxTable
    from luxloop.scenarios.recordings.ego_mount import EgoMount

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


@dataclass(frozen=True, slots=True, eq=False)
class DataSet:
    """Sweeps of a data set, which also has the poses of its ego and may have mounts and true boxes."""

    path: Path
    """Its file or folder."""
    frames: Ints
    """(F,) numbers of the frames by which true boxes name them, rising."""
    read: Callable[[int], list[Sweep]]
    """Reader of the sweeps of the frame in a row of `frames`, one for each LIDAR in the order of the mounts."""
    ego: PoseList
    """Poses of the ego."""
    mounts: "tuple[EgoMount, ...]" = ()
    """Mount of each LIDAR; empty if the data set does not have them."""
    truth: "Callable[[], list[BoxTable]] | None" = None
    """Reader of the true boxes, once for each frame of reference; None without any."""

    @property
    def count(self) -> int | None:
        """Number of frames, which are sweeps if there is one LIDAR."""
        return len(self.frames)

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the sweeps in order."""
        for row in range(len(self.frames)):
            yield from self.read(row)

    def poses(self, name: str) -> PoseList:
        """Raise an InputError: the data set has the poses of its ego only."""
        raise InputError(f"{self.path}: {name}: a data set has no topics; its own poses are read without --odometry")

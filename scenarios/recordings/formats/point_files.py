"""Files of one sweep each, as a recording."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.point_fields import sweep_of_table
from luxloop.scenarios.recordings.formats.reading_errors import readable
from luxloop.scenarios.recordings.sweep import PoseList, Sweep


@dataclass(frozen=True, slots=True)
class PointFiles:
    """Files in the order of time, as a `RecordingSource`."""

    paths: list[Path]
    read: Callable[[Path], npt.NDArray[np.void]]
    """Reader of the points (N,) of a file, with its fields."""
    what: str
    """Name of the format in messages."""
    period_s: float
    """Time between two files [s]."""

    @property
    def count(self) -> int | None:
        """Number of files."""
        return len(self.paths)

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the points of each file."""
        for number, path in enumerate(self.paths):
            with readable(path, self.what):
                sweep = sweep_of_table(self.read(path), number * self.period_s, 0)
            yield sweep

    def poses(self, name: str) -> PoseList:
        """Raise an InputError: these files hold no poses."""
        raise InputError(f"{self.paths[0]}: {name}: files of points hold no poses; leave --odometry and --truth out")

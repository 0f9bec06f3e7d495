"""Options of an import: mounts, layer cut, poses and scale."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.ego_mount import EgoMount
from luxloop.scenarios.recordings.layer_cut import ElevationCut, HeightCut

HEIGHT_M = 1.5
"""[m] Height of a box whose height is not given, of a passenger car."""


@dataclass(frozen=True, slots=True)
class TruthOption:
    """A vehicle with recorded poses. Lengths are in the units of the recording."""

    topic: str
    length_m: float
    width_m: float
    x_m: float = 0.0
    """Centre of the box in the frame of the poses, ahead [m]."""
    y_m: float = 0.0
    """The same, to the left [m]."""
    height_m: float = HEIGHT_M

    @classmethod
    def parse(cls, text: str) -> "TruthOption":
        """Read `TOPIC=LENGTH,WIDTH[,X,Y[,HEIGHT]]`.

        Raises
        ------
        InputError
            The text is of another form, or a side is not positive.
        """
        topic, _, rest = text.rpartition("=")
        try:
            numbers = [float(part) for part in rest.split(",")]
        except ValueError:
            numbers = []
        if not topic or len(numbers) not in (2, 4, 5) or not np.isfinite(numbers).all() or min(numbers[:2]) <= 0.0:
            raise InputError(
                f"--truth {text}: should be an existing file of true boxes, or TOPIC=LENGTH,WIDTH[,X,Y[,HEIGHT]] in "
                "metres"
            )
        return cls(topic, *numbers)

    @property
    def name(self) -> str:
        """Name of the vehicle: the topic without its slash."""
        return self.topic.strip("/")

    def centres(self, rows: Floats) -> Floats:
        """Return time, x, y, yaw (M, 4) of the box centre, from those of the poses (M, 4)."""
        cos, sin = np.cos(rows[:, 3]), np.sin(rows[:, 3])
        moved = rows.copy()
        moved[:, 1] += cos * self.x_m - sin * self.y_m
        moved[:, 2] += sin * self.x_m + cos * self.y_m
        return moved


EGO_SIZE_M = (4.8, 1.9, 1.5)
"""Length, width and height of the drawn ego [m]."""


@dataclass(frozen=True, slots=True)
class ImportOptions:
    """Settings of an import. Mounts, boxes and heights are in the units of the recording."""

    mounts: tuple[EgoMount, ...]
    """Pose of each LIDAR."""
    level: bool = False
    """Replace height, pitch and roll of each mount by those over the ground of the first sweep."""
    cut: ElevationCut | HeightCut | None = None
    """Layers to keep; None keeps all."""
    odometry: str | None = None
    """Topic of the ego's poses; None for an ego that stands."""
    truth: tuple[TruthOption, ...] = ()
    """Vehicles with recorded poses."""
    truth_files: tuple[Path, ...] = ()
    """Files of true boxes, of any format that is graded; they replace the boxes of a data set."""
    truth_delay_s: float = 0.0
    """Time by which true poses lag behind the scans [s]: those at a time are where the vehicles were before it."""
    heights_m: tuple[float, float] | None = None
    """Lowest and highest height above the ground to keep [m]; None keeps all."""
    sweep_time_s: float | None = None
    """Time from the first to the last point of a sweep [s], where points have no times or wrong ones. Recorded times
    are stretched to it; without any, times rise evenly in the order of the points."""
    scale_length: float = 1.0
    """Factor on all lengths."""
    scale_time: float = 1.0
    """Factor on all times."""
    files: tuple[str, ...] = field(default=())
    """Names of the imported files, for the summary."""

    def __post_init__(self) -> None:
        if self.truth and not self.odometry:
            raise InputError("--truth needs --odometry: poses of vehicles are relative to those of the ego")
        for name in ("scale_length", "scale_time"):
            if not 0.0 < getattr(self, name) < float("inf"):
                option = name.replace("_", "-")
                raise InputError(f"--{option} {getattr(self, name)}: should be a positive factor")

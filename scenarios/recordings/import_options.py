"""Options of an import: mounts, layer cut, poses and scale."""

from dataclasses import dataclass, field

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.ego_mount import EgoMount
from luxloop.scenarios.recordings.layer_cut import ElevationCut, HeightCut
from luxloop.scenarios.recordings.truth_option import TruthOption

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

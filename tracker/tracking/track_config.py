"""Configuration of one track."""

from dataclasses import dataclass

from tracker.tracking.confirmation import TrackLifeConfig
from tracker.tracking.corner_error import CornerConfig
from tracker.tracking.existence import MemoryConfig
from tracker.tracking.extent import ExtentConfig
from tracker.tracking.filters import FilterConfig
from tracker.tracking.orientation import OrientationConfig


@dataclass(frozen=True, slots=True)
class TrackConfig:
    """Sections of `TrackerConfig` that one track uses."""

    filters: FilterConfig
    extent: ExtentConfig
    orientation: OrientationConfig
    corner: CornerConfig
    life: TrackLifeConfig
    memory: MemoryConfig

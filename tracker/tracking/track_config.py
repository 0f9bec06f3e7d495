"""Configuration of one track."""

from dataclasses import dataclass

from luxloop.tracker.tracking.confirmation import ConfirmationConfig
from luxloop.tracker.tracking.corner_error import CornerConfig
from luxloop.tracker.tracking.existence import ExistenceConfig
from luxloop.tracker.tracking.filters import FilterConfig
from luxloop.tracker.tracking.orientation import OrientationConfig
from luxloop.tracker.tracking.vehicle_size import ExtentConfig


@dataclass(frozen=True, slots=True)
class TrackConfig:
    """Sections of `TrackerConfig` that one track uses."""

    filters: FilterConfig
    extent: ExtentConfig
    orientation: OrientationConfig
    corner: CornerConfig
    confirmation: ConfirmationConfig
    existence: ExistenceConfig

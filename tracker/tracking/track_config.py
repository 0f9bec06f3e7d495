"""Settings of tracks."""

from dataclasses import dataclass

from luxloop.tracker.tracking.confirmation import ConfirmationConfig
from luxloop.tracker.tracking.corner import CornerConfig
from luxloop.tracker.tracking.existence import ExistenceConfig
from luxloop.tracker.tracking.filters import FilterConfig
from luxloop.tracker.tracking.orientation import OrientationConfig
from luxloop.tracker.tracking.vehicle_size import ExtentConfig


@dataclass(frozen=True, slots=True)
class TrackConfig:
    """Sections of `TrackerConfig` that prediction, correction and management of tracks share."""

    filters: FilterConfig
    extent: ExtentConfig
    orientation: OrientationConfig
    corner: CornerConfig
    confirmation: ConfirmationConfig
    existence: ExistenceConfig

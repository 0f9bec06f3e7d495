"""Settings of tracks."""

from dataclasses import dataclass

from luxloop.tracker.tracking.confirmation import ConfirmationConfig
from luxloop.tracker.tracking.corner import CornerConfig
from luxloop.tracker.tracking.existence import ExistenceConfig
from luxloop.tracker.tracking.filters import FilterConfig


@dataclass(frozen=True, slots=True)
class TrackConfig:
    """Sections of `TrackerConfig` that prediction, correction and management of tracks share."""

    filters: FilterConfig
    corner: CornerConfig
    confirmation: ConfirmationConfig
    existence: ExistenceConfig

"""Oracle for model selection: a track selects the model of the true mode of motion of its vehicle.

The other models get a negligible probability, so that mixing starts all filters from the model of the true mode. A
track without an actor selects its model from its observations. The filters, their noise and the times of their
corrections are those of the tracker.
"""

from collections.abc import Sequence

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.mma_metrics import MODE_OF
from luxloop.scenarios.oracle.oracle_context import OracleContext
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking.filter_bank import SelectedBank
from luxloop.tracker.tracking.filters import FilterConfig, Filters, Motion, initial_filters
from luxloop.tracker.tracking.mma import LEAST_PROBABILITY, MmaConfig
from luxloop.tracker.tracking.model_selection import ModelSelection
from luxloop.tracker.tracking.observations import Observations
from luxloop.tracker.tracking.track import Track
from luxloop.tracker.tracking.track_management import TrackManagement


class OracleBank(SelectedBank):
    """Filter bank that selects the model of its actor's true mode."""

    def __init__(self, filters: Filters, config: MmaConfig, context: OracleContext) -> None:
        super().__init__(filters, config)
        self._models: tuple[str, ...] = MODELS
        self._context = context
        self.actor = NO_ACTOR
        """Actor that the track follows."""

    def predict(self, motion: Motion) -> None:
        """Move on by one time step and select the true mode at its end."""
        super().predict(motion)
        self._models = motion.names
        self.select()

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Correct the filters; the residuals do not change the selected model."""
        covariance = super().observe(residual, noise)
        self.select()
        return covariance

    def select(self) -> None:
        """Select the true mode of the actor; without an actor, keep the probabilities."""
        mode = self._context.truth.mode.get(self.actor)
        if mode is not None:
            self.probability = certain(mode, self._models)


class OracleModelSelection:
    """Model selection by the true mode of motion, a `ModelSelection`."""

    def __init__(self, filters: FilterConfig, mma: MmaConfig, context: OracleContext) -> None:
        self._filters = filters
        self._mma = mma
        self._context = context

    def new_bank(self, position: Floats, covariance: Floats) -> OracleBank:
        """Return the filter bank of a track that starts at (2,) [m] with covariance (2, 2) [m^2]."""
        return OracleBank(initial_filters(position, covariance, self._filters), self._mma, self._context)


class ActorRecorder:
    """Track management that also records which actor each track follows, and passes it to the filter banks."""

    def __init__(self, management: TrackManagement, context: OracleContext) -> None:
        self._management = management
        self._context = context

    def manage(
        self, tracks: Sequence[Track], seen: Observations, track_id: Ints, forward: float, models: ModelSelection
    ) -> list[Track]:
        """Decide on the tracks at the end of a frame, see `TrackManagement.manage`."""
        managed = self._management.manage(tracks, seen, track_id, forward, models)
        self._context.add_tracks(track_id)
        for track, actor in zip(managed, self._context.track_actor(managed).tolist(), strict=True):
            if isinstance(track.corner.bank, OracleBank):
                track.corner.bank.actor = actor
                track.corner.bank.select()
        return managed


def certain(mode: int, models: tuple[str, ...] = MODELS) -> Floats:
    """(M,) model probabilities of a known mode, equal for all models of it; above 0 for their logarithms.

    In a bank without a model of the mode all have the same probability.
    """
    describes = np.array([MODE_OF[model] == MODELS[mode] for model in models])
    share = np.where(describes | ~describes.any(), 1.0, LEAST_PROBABILITY)
    return np.asarray(share / share.sum())

"""Oracle for model selection: a track selects the model of the true mode of motion of its vehicle.

The other models get a negligible probability, so that mixing starts all filters from the model of the true mode. A
track without an actor selects its model from its observations. The filters, their noise and the times of their
corrections are those of the tracker.
"""

import numpy as np

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.grading.mma_metrics import MODE_OF
from luxloop.scenarios.oracle.oracle_context import OracleContext
from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking.filters import Step
from luxloop.tracker.tracking.mma import LEAST_PROBABILITY, MmaConfig
from luxloop.tracker.tracking.model_selection import ModelSelection, SelectedModel
from luxloop.tracker.tracking.observations import Observations
from luxloop.tracker.tracking.track_management import TrackManagement
from luxloop.tracker.tracking.track_table import TrackTable


class OracleModelSelection(SelectedModel):
    """Model selection by the true mode of motion of the vehicle that each track follows."""

    def __init__(self, config: MmaConfig, context: OracleContext) -> None:
        super().__init__(config)
        self._context = context

    def predict(self, tracks: TrackTable, step: Step, dt: float) -> None:
        """Move on by one time step and select the true mode at its end."""
        super().predict(tracks, step, dt)
        self.select(tracks)

    def correct(self, tracks: TrackTable, rows: Ints, innovation: Floats, noise: Floats) -> Floats:
        """Correct the filters; the innovations do not change the selected model."""
        used = super().correct(tracks, rows, innovation, noise)
        self.select(tracks)
        return used

    def select(self, tracks: TrackTable) -> None:
        """Select the true modes of the actors; tracks without an actor keep their probabilities."""
        modes = self._context.truth.mode
        for t, actor in enumerate(self._context.track_actor(tracks).tolist()):
            if actor in modes:
                tracks.probability[t] = certain(modes[actor], tracks.models)
        self.summarise(tracks, np.arange(len(tracks)))


class ActorRecorder:
    """Track management that also records which actor each track follows."""

    def __init__(self, management: TrackManagement, context: OracleContext) -> None:
        self._management = management
        self._context = context

    def manage(
        self, tracks: TrackTable, observations: Observations, track_id: Ints, forward: float, selection: ModelSelection
    ) -> TrackTable:
        """Decide on the tracks at the end of a frame, see `TrackManagement.manage`."""
        managed = self._management.manage(tracks, observations, track_id, forward, selection)
        self._context.add_tracks(track_id)
        if isinstance(selection, OracleModelSelection):
            selection.select(managed)
        return managed


def certain(mode: int, models: tuple[str, ...] = MODELS) -> Floats:
    """(M,) model probabilities of a known mode, equal for all models of it; above 0 for their logarithms.

    In a bank without a model of the mode all have the same probability.
    """
    describes = np.array([MODE_OF[model] == MODELS[mode] for model in models])
    share = np.where(describes | ~describes.any(), 1.0, LEAST_PROBABILITY)
    return np.asarray(share / share.sum())

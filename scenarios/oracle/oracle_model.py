"""The truth for the choice of a model: a track selects the model of the mode in which its vehicle truly moves.

The others are as good as impossible, so that filters that talk start from the true mode's; a track of nobody chooses
for itself. The filters, their noise and when they are corrected are the tracker's own.
"""

import numpy as np

from scenarios.arrays import Floats
from tracker.records import MODELS
from tracker.tracking.filter_bank import SelectedBank
from tracker.tracking.mma import LEAST_PROBABILITY


class ToldBank(SelectedBank):
    """A bank that is told the mode."""

    _mode: int | None = None

    def tell(self, mode: int | None) -> None:
        """Select the model of this mode from now on; None leaves it the choice."""
        self._mode = mode
        self._select()

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Correct the filters; what the residuals say of the models is not listened to."""
        raised = super().observe(residual, noise)
        self._select()
        return raised

    def _select(self) -> None:
        if self._mode is not None:
            self.probability = certain(self._mode)


def certain(mode: int) -> Floats:
    """(M,) probabilities of a mode that is known; logarithms of the others are taken, so that they are not zero."""
    probability = np.full(len(MODELS), LEAST_PROBABILITY)
    probability[mode] = 1.0 - LEAST_PROBABILITY * (len(MODELS) - 1)
    return probability

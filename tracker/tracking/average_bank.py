"""Filter bank of independent filters that reports their mean, the multiple-model adaptive estimator."""

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking import mma
from luxloop.tracker.tracking.filter_bank import ScoredFilters
from luxloop.tracker.tracking.filters import Filters, Motion
from luxloop.tracker.tracking.mma import MmaConfig


class AverageBank(ScoredFilters):
    """Independent filters without mixing, averaged by their probabilities (Magill 1965)."""

    def __init__(self, filters: Filters, config: MmaConfig) -> None:
        super().__init__(filters, config.tail_dof, config.probability_floor)

    @property
    def mode_time_s(self) -> float:
        """Infinite: a vehicle stays in its mode."""
        return np.inf

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """Mean (6,) and covariance (6, 6) of the mixture."""
        one = np.ones((len(self.probability), 1))
        mixed, _ = mma.mix(self.filters, self.probability, one)
        return mixed.mean[0], mixed.covariance[0]

    def predict(self, motion: Motion) -> None:
        """Move on by one time step."""
        self.filters.predict(motion.models)

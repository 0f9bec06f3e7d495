"""Filter bank of independent filters that reports their mean, the multiple-model adaptive estimator."""

import numpy as np

from tracker.arrays import Floats
from tracker.tracking import mma
from tracker.tracking.filters import Filters, Motion
from tracker.tracking.mma import MmaConfig


class AverageBank:
    """Independent filters without mixing, averaged by their probabilities (Magill 1965)."""

    def __init__(self, filters: Filters, config: MmaConfig) -> None:
        self.filters = filters
        self.probability = mma.initial_probability(len(filters.mean))
        self._config = config

    @property
    def weights(self) -> Floats:
        """(M,) model probabilities."""
        return self.probability

    @property
    def mode_time_s(self) -> float:
        """Infinite: a vehicle stays in its mode."""
        return np.inf

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """Mean (6,) and covariance (6, 6) of the mixture."""
        one, weights = np.ones((len(self.probability), 1)), self.probability
        mixed, _ = mma.mix(self.filters, weights, one)
        return mixed.mean[0], mixed.covariance[0]

    def predict(self, motion: Motion) -> None:
        """Move on by one time step."""
        self.filters.predict(motion.models)

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Score the filters by (12) and correct them; see `FilterBank.observe`."""
        evidence, scale = mma.score(self.filters, residual, noise, self._config.tail_dof)
        self.probability = mma.update(self.probability, evidence, self._config.probability_floor)
        self.filters.correct(residual, scale * noise)
        return scale * noise

    def shift(self, offset: Floats) -> None:
        """Move the tracked point by (2,) [m]."""
        self.filters.mean[:, :2] += offset

    def inflate(self, covariance: Floats) -> None:
        """Add (2, 2) [m^2] to the covariance of the tracked point."""
        self.filters.covariance[:, :2, :2] += covariance

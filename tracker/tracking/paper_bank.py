"""Filter bank of the paper: filterpy's Kalman filters without mixing; that of the highest score is reported."""

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking import filterpy_filters, mma
from luxloop.tracker.tracking.filters import Filters, Motion
from luxloop.tracker.tracking.mma import MmaConfig


class PaperBank:
    """Independent filters by (6) to (9), scored by (10) to (12)."""

    def __init__(self, filters: Filters, config: MmaConfig) -> None:
        self._models = filterpy_filters.kalman_filters(filters)
        self.probability = mma.initial_probability(len(filters.mean))
        self._config = config

    @property
    def model(self) -> int:
        """Index of the filter of the highest score."""
        return int(self.probability.argmax())

    @property
    def weights(self) -> Floats:
        """(M,) one for the filter of the highest score."""
        return np.asarray(np.arange(len(self.probability)) == self.model, dtype=np.float64)

    @property
    def filters(self) -> Filters:
        """The M filters, copied."""
        return filterpy_filters.states(self._models)

    @property
    def mode_time_s(self) -> float:
        """Infinite: a vehicle stays in its mode."""
        return np.inf

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """State (6,) and covariance (6, 6) of the filter of the highest score."""
        best = self._models[self.model]
        return np.asarray(best.x), np.asarray(best.P)

    def predict(self, motion: Motion) -> None:
        """Move on by one time step."""
        filterpy_filters.set_motion(self._models, motion)
        for kf in self._models:
            kf.predict()

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Score the filters by (12) and correct each by its own innovation; see `FilterBank.observe`."""
        evidence, scale = mma.score(self.filters, residual, noise, self._config.tail_dof)
        self.probability = mma.update(self.probability, evidence, self._config.probability_floor)
        for kf, innovation in zip(self._models, residual, strict=True):
            kf.update(kf.x[:2] + innovation, R=scale * noise)
        return scale * noise

    def shift(self, change: Floats) -> None:
        """Change the state by (6,), to that of another point of the same vehicle."""
        filterpy_filters.shift(self._models, change)

    def inflate(self, covariance: Floats) -> None:
        """Add (n, n), or one (n, n) per model, to the covariance of the first n states."""
        filterpy_filters.inflate(self._models, covariance)

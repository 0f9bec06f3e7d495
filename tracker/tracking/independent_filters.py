"""Each model of the bank by itself, for comparison: the same observations, and nothing from the others."""

import numpy as np

from tracker.arrays import Floats
from tracker.geometry import mahalanobis
from tracker.records import MODELS
from tracker.tracking.filters import FilterConfig, Step, initial_filters


class IndependentFilters:
    """The filters of a bank that do not talk."""

    def __init__(self, position: Floats, covariance: Floats, config: FilterConfig) -> None:
        self.filters = initial_filters(position, covariance, config)
        self.nis = np.full(len(MODELS), np.nan)
        """(M,) squared innovations over their covariances, NaN when not seen."""

    def predict(self, step: Step) -> None:
        """Move on by one time step."""
        self.filters.predict(step)
        self.nis = np.full(len(MODELS), np.nan)

    def observe(self, measured: Floats, covariance: Floats) -> None:
        """Correct by the measured corner (2,) [m] of covariance (2, 2)."""
        residual = measured - self.filters.mean[:, :2]
        self.nis, _ = mahalanobis(residual, self.filters.covariance[:, :2, :2] + covariance)
        self.filters.correct(residual, covariance)

    def inflate(self, covariance: Floats) -> None:
        """Know the place less well, by a covariance (2, 2) [m^2]."""
        self.filters.covariance[:, :2, :2] += covariance

    def shift(self, offset: Floats) -> None:
        """Follow another point, (2,) [m] away."""
        self.filters.mean[:, :2] += offset

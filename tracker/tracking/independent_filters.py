"""Independent filters, one per model, to compare the models: same observations, no mixing."""

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking.filters import FilterConfig, Filters, Step, initial_filters
from luxloop.tracker.tracking.kernels import filter_banks as kernel


class IndependentFilters:
    """Filters of all models without mixing."""

    def __init__(self, position: Floats, covariance: Floats, config: FilterConfig) -> None:
        self.filters = initial_filters(position, covariance, config)
        self.nis = np.full(len(self.filters.mean), np.nan)
        """(M,) normalised innovations squared, NaN without an observation in this frame."""

    def predict(self, step: Step) -> None:
        """Move on by one time step."""
        self.filters.predict(step)
        self.nis = np.full(len(self.filters.mean), np.nan)

    def observe(self, measured: Floats, covariance: Floats) -> None:
        """Correct by the measured corner (2,) [m] with covariance (2, 2) [m^2]."""
        one = self.filters.mean[None], self.filters.covariance[None], measured[None], covariance[None]
        mean, spread, nis = kernel.observe_independent(*one, np.zeros((1, 2, 2)))
        self.filters, self.nis = Filters(mean[0], spread[0]), nis[0]

    def inflate(self, covariance: Floats) -> None:
        """Add (n, n), or one (n, n) per model, to the covariance of the first n states."""
        n = covariance.shape[-1]
        self.filters.covariance[:, :n, :n] += covariance

    def shift(self, change: Floats) -> None:
        """Change the state by (6,), to that of another point of the same vehicle."""
        self.filters.mean += change

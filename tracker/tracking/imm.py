"""Filter bank with filterpy's interacting multiple model, the reference for multiple-model association."""

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking import filterpy_filters, mma
from luxloop.tracker.tracking.filters import Filters, Motion
from luxloop.tracker.tracking.mma import MmaConfig


class FilterpyImm:
    """Filter bank that reports the mean of all models, weighted by their probabilities (Blom and Bar-Shalom 1988)."""

    def __init__(self, filters: Filters, config: MmaConfig) -> None:
        from filterpy.kalman import IMMEstimator

        self._config = config
        # M[i, j] is the probability of the change from i to j; filterpy's docstring says the opposite.
        self._imm = IMMEstimator(
            filterpy_filters.kalman_filters(filters),
            mma.initial_probability(len(filters.mean)),
            np.eye(len(filters.mean)),
        )

    @property
    def probability(self) -> Floats:
        """(M,) model probabilities."""
        return np.asarray(self._imm.mu)

    @property
    def model(self) -> int:
        """Index of the likeliest model."""
        return int(self.probability.argmax())

    @property
    def weights(self) -> Floats:
        """(M,) model probabilities."""
        return self.probability

    @property
    def mode_time_s(self) -> float:
        """Mean time in a mode [s]."""
        return self._config.mode_time_s

    @property
    def filters(self) -> Filters:
        """The M filters, copied."""
        return filterpy_filters.states(self._imm.filters)

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """Mean (6,) and covariance (6, 6) of the mixture."""
        return np.asarray(self._imm.x), np.asarray(self._imm.P)

    def predict(self, motion: Motion) -> None:
        """Mix the models and move on by one time step."""
        imm = self._imm
        imm.M = mma.transitions(self.filters, motion.dt, self._config, motion.names)
        # filterpy uses the last scan's M; here it depends on the state, and on the time without observations.
        imm.cbar = imm.mu @ imm.M
        imm.omega = imm.mu[:, None] * imm.M / imm.cbar
        imm.mu = imm.cbar
        filterpy_filters.set_motion(imm.filters, motion)
        imm.predict()

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Update by the innovation of the likeliest model: filterpy passes the same measurement to all models."""
        best = self.model
        _, scale = mma.score(self.filters, residual, noise, self._config.tail_dof)
        for kf in self._imm.filters:
            kf.R = scale * noise
        self._imm.update(self._imm.filters[best].x[:2] + residual[best])
        return scale * noise

    def shift(self, change: Floats) -> None:
        """Change the state by (6,), to that of another point of the same vehicle."""
        filterpy_filters.shift([*self._imm.filters, self._imm], change)

    def inflate(self, covariance: Floats) -> None:
        """Add (n, n), or one (n, n) per model, to the covariance of the first n states."""
        filterpy_filters.inflate(self._imm.filters, covariance)
        filterpy_filters.inflate([self._imm], covariance if covariance.ndim == 2 else covariance.max(axis=0))

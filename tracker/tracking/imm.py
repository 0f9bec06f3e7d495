"""Filter bank with filterpy's interacting multiple model, the reference for multiple-model association."""

from typing import TYPE_CHECKING

import numpy as np

from tracker.arrays import Floats
from tracker.records import MODELS
from tracker.tracking import mma
from tracker.tracking.filters import STATE_DIM, Filters, Motion
from tracker.tracking.mma import MmaConfig

if TYPE_CHECKING:
    from filterpy.kalman import KalmanFilter


class FilterpyImm:
    """Filter bank that reports the mean of all models, weighted by their probabilities (Blom and Bar-Shalom 1988)."""

    def __init__(self, filters: Filters, config: MmaConfig) -> None:
        from filterpy.kalman import IMMEstimator

        self._config = config
        # M[i, j] is the probability of the change from i to j; filterpy's docstring says the opposite.
        self._imm = IMMEstimator(
            [_kalman(mean, covariance) for mean, covariance in zip(filters.mean, filters.covariance, strict=True)],
            mma.initial_probability(),
            np.eye(len(MODELS)),
        )

    @property
    def probability(self) -> Floats:
        """(M,) model probabilities."""
        return np.asarray(self._imm.mu)

    @property
    def filters(self) -> Filters:
        """The M filters, copied."""
        models = self._imm.filters
        return Filters(np.array([kf.x for kf in models]), np.array([kf.P for kf in models]))

    @property
    def estimate(self) -> tuple[Floats, Floats]:
        """Mean (6,) and covariance (6, 6) of the mixture."""
        return np.asarray(self._imm.x), np.asarray(self._imm.P)

    def predict(self, motion: Motion) -> None:
        """Mix the models and move on by one time step."""
        imm = self._imm
        imm.M = mma.transitions(self.filters, motion.dt, self._config)
        # filterpy uses the last scan's M; here it depends on the state, and on the time without observations.
        imm.cbar = imm.mu @ imm.M
        imm.omega = imm.mu[:, None] * imm.M / imm.cbar
        imm.mu = imm.cbar
        for kf, transition, noise in zip(imm.filters, motion.models.transition, motion.models.noise, strict=True):
            kf.F, kf.Q = transition, noise
        imm.predict()

    def observe(self, residual: Floats, noise: Floats) -> Floats:
        """Update by the innovation of the likeliest model: filterpy passes the same measurement to all models."""
        best = int(np.argmax(self._imm.mu))
        _, scale = mma.score(self.filters, residual, noise, self._config.tail_dof)
        for kf in self._imm.filters:
            kf.R = scale * noise
        self._imm.update(self._imm.filters[best].x[:2] + residual[best])
        return scale * noise

    def shift(self, offset: Floats) -> None:
        """Move the tracked point by (2,) [m]."""
        for kf in (*self._imm.filters, self._imm):
            kf.x[:2] += offset

    def inflate(self, covariance: Floats) -> None:
        """Add (2, 2) [m^2] to the covariance of the tracked point."""
        for kf in (*self._imm.filters, self._imm):
            kf.P[:2, :2] += covariance


def _kalman(mean: Floats, covariance: Floats) -> "KalmanFilter":
    """Return the Kalman filter of one model, with x and y as measurement."""
    from filterpy.kalman import KalmanFilter

    kf = KalmanFilter(dim_x=STATE_DIM, dim_z=2)
    kf.x, kf.P, kf.H = mean.copy(), covariance.copy(), np.eye(2, STATE_DIM)
    return kf

"""filterpy's Kalman filters with the states of the filter bank."""

from typing import TYPE_CHECKING

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.tracking.filters import STATE_DIM, Filters, Motion

if TYPE_CHECKING:
    from filterpy.kalman import KalmanFilter


def kalman_filters(filters: Filters) -> list["KalmanFilter"]:
    """Return filterpy's Kalman filter of each model, with x and y as measurement."""
    from filterpy.kalman import KalmanFilter

    made = []
    for mean, covariance in zip(filters.mean, filters.covariance, strict=True):
        kf = KalmanFilter(dim_x=STATE_DIM, dim_z=2)
        kf.x, kf.P, kf.H = mean.copy(), covariance.copy(), np.eye(2, STATE_DIM)
        made.append(kf)
    return made


def set_motion(models: list["KalmanFilter"], motion: Motion) -> None:
    """Give each filter the transition and the process noise of its model."""
    for kf, transition, noise in zip(models, motion.models.transition, motion.models.noise, strict=True):
        kf.F, kf.Q = transition, noise


def states(models: list["KalmanFilter"]) -> Filters:
    """Return the states of the filters, copied."""
    return Filters(np.array([kf.x for kf in models]), np.array([kf.P for kf in models]))


def shift(models: list["KalmanFilter"], change: Floats) -> None:
    """Change the states by (6,), to those of another point of the same vehicle."""
    for kf in models:
        kf.x += change


def inflate(models: list["KalmanFilter"], covariance: Floats) -> None:
    """Add (n, n), or one (n, n) per model, to the covariance of the first n states."""
    n = covariance.shape[-1]
    for kf, added in zip(models, np.broadcast_to(covariance, (len(models), n, n)), strict=True):
        kf.P[:n, :n] += added

"""Reference implementations of the kernels of filters and filter banks: the same equations in plain numpy."""

import numpy as np
import scipy
from support.filter_bank import Filters

from luxloop.tracker.geometry import mahalanobis
from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking.mma import LEAST_PROBABILITY, NO_SPEED_MPS, STANDING_MPS, STOPPING_TIME_S


def predict(mean, covariance, transition, noise):
    """Move filters (..., n) on by one time step."""
    moved = (transition @ mean[..., None])[..., 0]
    return moved, transition @ covariance @ transition.swapaxes(-1, -2) + noise


def correct(mean, covariance, residual, noise):
    """Correct filters (..., n) by innovations (..., m) of their first m states."""
    measured = residual.shape[-1]
    innovation = covariance[..., :measured, :measured] + noise
    gain = np.linalg.solve(innovation, covariance[..., :measured, :]).swapaxes(-1, -2)
    spread = covariance - gain @ covariance[..., :measured, :]
    return mean + (gain @ residual[..., None])[..., 0], 0.5 * (spread + spread.swapaxes(-1, -2))


def transitions(filters, dt, config, models=MODELS):
    """(..., M, M) probability of the change from one mode (row) to another (column) within `dt` [s]."""
    leaves = -np.expm1(-dt / config.mode_time_s) / max(len(models) - 1, 1)
    chain = np.full((*filters.mean.shape[:-1], len(models)), leaves)
    if "stationary" in models:
        stops = -np.expm1(-dt / STOPPING_TIME_S) * slow(filters, STANDING_MPS)
        chain[..., models.index("stationary")] = np.maximum(stops, LEAST_PROBABILITY)
    same = np.arange(len(models))
    chain[..., same, same] = 0.0
    chain /= np.maximum(chain.sum(axis=-1, keepdims=True), 1.0)
    chain[..., same, same] = 1.0 - chain.sum(axis=-1)
    return chain


def slow(filters, limit_mps):
    """(..., M) probability by each filter that the speed along its direction of motion is below the limit."""
    velocity, covariance = filters.mean[..., 2:4], filters.covariance[..., 2:4, 2:4]
    speed = np.hypot(velocity[..., 0], velocity[..., 1])
    moves = speed[..., None] > NO_SPEED_MPS
    direction = np.where(moves, velocity / np.maximum(speed, NO_SPEED_MPS)[..., None], (1.0, 0.0))
    std = np.sqrt(np.einsum("...i,...ij,...j->...", direction, covariance, direction))
    return scipy.special.ndtr((limit_mps - speed) / std) - scipy.special.ndtr((-limit_mps - speed) / std)


def mix(filters, probability, chain):
    """Return the mixed filters, and the model probabilities (..., M) before (12)."""
    flow = probability[..., None] * chain
    prior = flow.sum(axis=-2)
    share = flow / prior[..., None, :]
    mean = share.swapaxes(-1, -2) @ filters.mean
    difference = filters.mean[..., :, None, :] - mean[..., None, :, :]
    second_moment = filters.covariance[..., :, None, :, :] + difference[..., :, None] * difference[..., None, :]
    return Filters(mean, np.einsum("...ij,...ijkl->...jkl", share, second_moment)), prior


def score(filters, residual, noise, tail_dof):
    """Log-likelihood (11) of each model, and a scale for the measurement noise."""
    squared, determinant = mahalanobis(residual, filters.covariance[..., :2, :2] + noise[..., None, :, :])
    density = -0.5 * (tail_dof + 2) * np.log1p(squared / tail_dof) - 0.5 * np.log((2 * np.pi) ** 2 * determinant)
    return density, np.maximum(1.0, (tail_dof + squared.min(axis=-1)) / (tail_dof + 2))


def update(probability, evidence, floor=LEAST_PROBABILITY):
    """Return the model probabilities (..., M) after one observation, equation (12) in logarithms."""
    score = np.log(probability) + evidence
    posterior = np.exp(score - score.max(axis=-1, keepdims=True))
    posterior = np.maximum(posterior / posterior.sum(axis=-1, keepdims=True), floor)
    return posterior / posterior.sum(axis=-1, keepdims=True)

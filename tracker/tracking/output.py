"""Conversion of tracks to the `Tracks` record."""

from collections.abc import Sequence

import numpy as np

from luxloop.tracker.arrays import Floats
from luxloop.tracker.records import MODEL_NAMES, MODELS, PREDICTION_S, Tracks
from luxloop.tracker.tracking.filters import STATE_DIM, stacked
from luxloop.tracker.tracking.kernels import prediction as kernel
from luxloop.tracker.tracking.kernels.turns import Complexes
from luxloop.tracker.tracking.track import Track
from luxloop.tracker.tracking.track_arrays import offset_covariances
from luxloop.tracker.tracking.turning import turning_among

REPORTED_DIM = 8
"""State of the filters, then heading and yaw rate."""


def states(tracks: Sequence[Track], offset: Floats) -> tuple[Floats, Floats]:
    """Return states (T, 8) and covariances (T, 8, 8) in the order of (6); states that a selected model omits are zero.

    `offset` (T, 2, 2) is the covariance of the time-correlated error of each tracked corner [m^2].
    """
    count, turned = len(tracks), slice(STATE_DIM, None)
    mean, covariance = np.zeros((count, REPORTED_DIM)), np.zeros((count, REPORTED_DIM, REPORTED_DIM))
    if tracks:
        mean[:, :STATE_DIM], covariance[:, :STATE_DIM, :STATE_DIM] = _stacked([t.corner.bank.estimate for t in tracks])
        mean[:, turned], covariance[:, turned, turned] = _stacked([track.yaw_state for track in tracks])
    covariance[:, :2, :2] += offset
    return mean, covariance


def _stacked(states: Sequence[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """Return means (T, n) and covariances (T, n, n) of T states."""
    means, covariances = zip(*states, strict=True)
    return np.array(means), np.array(covariances)


def report(tracks: Sequence[Track], models: tuple[str, ...] = MODELS) -> Tracks:
    """Return one row per track, oldest first; `models` are the names of their filters."""
    count, m = len(tracks), len(models)
    independent = [track.corner.independent for track in tracks]
    position, of_corner = stacked([own.filters for own in independent])
    offset = offset_covariances(tracks)
    mean, covariance = states(tracks, offset)
    return Tracks(
        id=np.array([track.id for track in tracks], dtype=np.int64),
        status=np.array([track.status for track in tracks], dtype=np.uint8),
        mean=mean,
        covariance=covariance,
        model_probability=np.array([track.corner.bank.probability for track in tracks]).reshape(count, m),
        model=np.array([track.corner.model for track in tracks], dtype=np.int64),
        model_position_odom=position.reshape(count, m, STATE_DIM)[:, :, :2].copy(),
        corner_sign=np.array([track.corner.sign for track in tracks], dtype=np.int64).reshape(count, 2),
        size=np.array([track.size for track in tracks]).reshape(count, 2),
        model_covariance_odom=of_corner.reshape(count, m, STATE_DIM, STATE_DIM)[:, :, :2, :2] + offset[:, None],
        model_nis=np.array([own.nis for own in independent]).reshape(count, m),
        prediction_odom=predictions(tracks, models),
        models=models,
    )


def predictions(tracks: Sequence[Track], models: tuple[str, ...]) -> Floats:
    """(T, M + 1, H, 2) predicted corners by the independent filters, then by the bank [m]."""
    if not tracks:
        return np.zeros((0, len(models) + 1, len(PREDICTION_S), 2))
    banks = [track.corner.bank for track in tracks]
    independent = np.array([track.corner.independent.filters.mean for track in tracks])
    means, weights = np.array([bank.filters.mean for bank in banks]), np.array([bank.weights for bank in banks])
    mode_time_s, inputs = np.array([bank.mode_time_s for bank in banks]), known_inputs(tracks, models)
    indices = np.array([MODEL_NAMES.index(name) for name in models])
    return np.asarray(kernel.predict(independent, means, weights, mode_time_s, *inputs, indices))


def known_inputs(tracks: Sequence[Track], models: tuple[str, ...]) -> tuple[Floats, Complexes]:
    """Return yaw rates (T,) and directions of motion (T,), for turning models; zero without them."""
    if not turning_among(models):
        return np.zeros(len(tracks)), np.zeros(len(tracks), dtype=np.complex128)
    turns = [track.turn for track in tracks]
    directions = np.array([turn.direction for turn in turns], dtype=np.complex128)
    return np.array([turn.yaw_rate for turn in turns]), directions

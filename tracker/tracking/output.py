"""Conversion of tracks to the `Tracks` record."""

import numpy as np

from tracker.arrays import Floats
from tracker.records import MODELS, Tracks
from tracker.tracking.filters import STATE_DIM
from tracker.tracking.track import Track

REPORTED_DIM = 8
"""State of the filters, then heading and yaw rate."""


def state(track: Track) -> tuple[Floats, Floats]:
    """Return state (8,) and covariance (8, 8) in the order of (6); states that the selected model omits are zero."""
    mean, covariance = np.zeros(REPORTED_DIM), np.zeros((REPORTED_DIM, REPORTED_DIM))
    mean[:STATE_DIM], covariance[:STATE_DIM, :STATE_DIM] = track.corner.bank.estimate
    mean[STATE_DIM:], covariance[STATE_DIM:, STATE_DIM:] = track.yaw_state
    covariance[:2, :2] = track.covariance
    return mean, covariance


def report(tracks: list[Track]) -> Tracks:
    """Return one row per track, oldest first."""
    states = [state(track) for track in tracks]
    count, models = len(tracks), len(MODELS)
    independent = [track.corner.independent.filters for track in tracks]
    covariance = [
        own.covariance[:, :2, :2] + track.offset_covariance for own, track in zip(independent, tracks, strict=True)
    ]
    return Tracks(
        id=np.array([track.id for track in tracks], dtype=np.int64),
        status=np.array([track.status for track in tracks], dtype=np.uint8),
        mean=np.array([mean for mean, _ in states]).reshape(count, REPORTED_DIM),
        covariance=np.array([cov for _, cov in states]).reshape(count, REPORTED_DIM, REPORTED_DIM),
        model_probability=np.array([track.corner.bank.probability for track in tracks]).reshape(count, models),
        model=np.array([track.corner.model for track in tracks], dtype=np.int64),
        model_position_odom=np.array([track.corner.independent.filters.mean[:, :2] for track in tracks]).reshape(
            count, models, 2
        ),
        corner_sign=np.array([track.corner.sign for track in tracks], dtype=np.int64).reshape(count, 2),
        size=np.array([track.size for track in tracks]).reshape(count, 2),
        model_covariance_odom=np.array(covariance).reshape(count, models, 2, 2),
        model_nis=np.array([track.corner.independent.nis for track in tracks]).reshape(count, models),
    )

"""Living tracks as the flat `Tracks` record."""

import numpy as np

from tracker.records import MODELS, Floats, Tracks
from tracker.track import Track

STATE_DIM = 8
HEADING = slice(6, 8)


def state(track: Track) -> tuple[Floats, Floats]:
    """State (8,) and covariance (8, 8) in the order of (6); what the selected model sets to zero stays zero."""
    mean, covariance = np.zeros(STATE_DIM), np.zeros((STATE_DIM, STATE_DIM))
    kf, heading = track.bank.models[track.model], track.bank.heading
    mean[: kf.dim_x], mean[HEADING] = kf.x, heading.x
    covariance[: kf.dim_x, : kf.dim_x], covariance[HEADING, HEADING] = kf.P, heading.P
    return mean, covariance


def report(tracks: list[Track]) -> Tracks:
    """One row per track, oldest first."""
    states = [state(track) for track in tracks]
    count = len(tracks)
    return Tracks(
        id=np.array([track.id for track in tracks], dtype=np.int64),
        status=np.array([track.status for track in tracks], dtype=np.uint8),
        mean=np.array([mean for mean, _ in states]).reshape(count, STATE_DIM),
        covariance=np.array([cov for _, cov in states]).reshape(count, STATE_DIM, STATE_DIM),
        model_probability=np.array([t.model_probability for t in tracks]).reshape(count, len(MODELS)),
        model=np.array([track.model for track in tracks], dtype=np.int64),
        model_position_odom=np.array([[kf.x[:2] for kf in t.bank.models] for t in tracks]).reshape(
            count, len(MODELS), 2
        ),
        corner_sign=np.array([track.corner_sign for track in tracks], dtype=np.int64).reshape(count, 2),
        size=np.array([track.size for track in tracks]).reshape(count, 2),
    )

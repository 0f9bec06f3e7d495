"""Lists of tracks as arrays."""

from collections.abc import Sequence

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import inside
from tracker.kernels import boxes as kernel
from tracker.merging import Pieces
from tracker.records import MODELS
from tracker.tracking import extent
from tracker.tracking.filters import STATE_DIM
from tracker.tracking.hypotheses import Predictions
from tracker.tracking.kernels.corner_error import rotated
from tracker.tracking.track import Track
from tracker.tracking.traffic_flow import FlowConfig, TrafficFlow


def tracked_corners(tracks: Sequence[Track]) -> tuple[Floats, Floats, Ints]:
    """Return tracked corners (T, 2) [m], headings (T,) [rad] and the signs (T, 2) of these corners."""
    corner = np.array([track.corner.bank.estimate[0] for track in tracks]).reshape(-1, STATE_DIM)[:, :2].copy()
    heading = np.array([track.heading for track in tracks])
    return corner, heading, np.array([track.corner.sign for track in tracks], dtype=np.int64).reshape(-1, 2)


def sizes(tracks: Sequence[Track]) -> Floats:
    """(T, 2) lengths and widths [m], unseen parts from priors."""
    return np.array([track.size for track in tracks]).reshape(-1, 2)


def seen_sizes(tracks: Sequence[Track]) -> Floats:
    """(T, 2) seen lengths and widths [m]."""
    return np.array([track.seen_size for track in tracks]).reshape(-1, 2)


def likely_sizes(tracks: Sequence[Track]) -> Floats:
    """(T, 2) parts of lengths and widths that probably exist, from the tracked corners on [m]."""
    std = np.array([track.size_std for track in tracks]).reshape(-1, 2)
    return extent.likely(seen_sizes(tracks), sizes(tracks), std)


def boxes(tracks: Sequence[Track]) -> tuple[Floats, Floats, Floats]:
    """Return centres (T, 2) [m], headings (T,) [rad] and sizes (T, 2) [m] of tracks, odometry frame."""
    return from_corners(tracks, sizes(tracks))


def from_corners(tracks: Sequence[Track], size: Floats) -> tuple[Floats, Floats, Floats]:
    """Return centres (T, 2) [m], headings (T,) [rad] and sizes of boxes of `size` (T, 2) [m] at the tracked corners."""
    corner, heading, sign = tracked_corners(tracks)
    return kernel.centers(corner, sign, heading, size), heading, size


def offset_covariances(tracks: Sequence[Track]) -> Floats:
    """(T, 2, 2) covariances of the time-correlated errors of the tracked corners [m^2]."""
    variance = np.array([track.corner.error.variance for track in tracks]).reshape(-1, 2)
    return np.asarray(rotated(variance, np.array([track.heading for track in tracks])))


def velocities(tracks: Sequence[Track]) -> Floats:
    """(T, 2) velocities [m/s]."""
    return np.array([track.corner.velocity for track in tracks]).reshape(-1, 2)


def within(points: Floats, tracks: Sequence[Track]) -> Bools:
    """(P, T) mask of points (P, 2) inside the likely parts of tracks."""
    return inside(points, *from_corners(tracks, likely_sizes(tracks)))


def pieces(tracks: Sequence[Track]) -> Pieces:
    """Return the seen parts of tracks."""
    center, heading, size = from_corners(tracks, seen_sizes(tracks))
    return Pieces(center, heading, size, velocities(tracks), np.array([track.hits for track in tracks]))


def flow(tracks: Sequence[Track], forward: float, config: FlowConfig) -> TrafficFlow:
    """Return positions and directions of the tracks whose direction is known, beside an ego of heading `forward`."""
    known = [track for track in tracks if track.shows_direction]
    corner, heading, _ = tracked_corners(known)
    return TrafficFlow(np.array([track.id for track in known], dtype=np.int64), corner, heading, forward, config)


def predictions(tracks: Sequence[Track]) -> Predictions:
    """Return the predicted states of T tracks; T may be 0."""
    count = len(tracks)
    filters = [track.corner.bank.filters for track in tracks]
    models = len(filters[0].mean) if filters else len(MODELS)
    mean = np.array([bank.mean for bank in filters]).reshape(count, models, STATE_DIM)
    covariance = np.array([bank.covariance[:, :2, :2] for bank in filters]).reshape(count, models, 2, 2)
    return Predictions(
        position=mean[:, :, :2].copy(),
        velocity=mean[:, :, 2:4].copy(),
        covariance=covariance + offset_covariances(tracks)[:, None],
        probability=np.array([track.corner.bank.probability for track in tracks]).reshape(count, models),
        heading=np.array([track.heading for track in tracks]),
        heading_variance=np.array([track.heading_variance for track in tracks]),
        size=sizes(tracks),
        known_size=np.array([track.known_size for track in tracks]).reshape(count, 2),
        whole=np.array([track.whole_views for track in tracks]).reshape(count, 2) > 0,
        corner_sign=np.array([track.corner.sign for track in tracks], dtype=np.int64).reshape(count, 2),
    )

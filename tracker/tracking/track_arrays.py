"""Lists of tracks as arrays."""

from collections.abc import Sequence

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import inside, rotate
from tracker.merging import Pieces
from tracker.records import MODELS
from tracker.tracking.hypotheses import Predictions
from tracker.tracking.kernels.corner_error import rotated
from tracker.tracking.track import Track
from tracker.tracking.traffic_flow import FlowConfig, TrafficFlow


def tracked_corners(tracks: Sequence[Track]) -> tuple[Floats, Floats, Ints]:
    """Return tracked corners (T, 2) [m], headings (T,) [rad] and the signs (T, 2) of these corners."""
    corner = np.reshape([track.corner.position for track in tracks], (-1, 2))
    heading = np.array([track.heading for track in tracks])
    return corner, heading, np.array([track.corner.sign for track in tracks], dtype=np.int64).reshape(-1, 2)


def boxes(tracks: Sequence[Track]) -> tuple[Floats, Floats, Floats]:
    """Return centres (T, 2) [m], headings (T,) [rad] and sizes (T, 2) [m] of tracks, odometry frame."""
    return from_corners(tracks, np.reshape([track.size for track in tracks], (-1, 2)))


def from_corners(tracks: Sequence[Track], size: Floats) -> tuple[Floats, Floats, Floats]:
    """Return centres (T, 2) [m], headings (T,) [rad] and sizes of boxes of `size` (T, 2) [m] at the tracked corners."""
    corner, heading, sign = tracked_corners(tracks)
    return corner - rotate(0.5 * sign * size, heading), heading, size


def offset_covariances(tracks: Sequence[Track]) -> Floats:
    """(T, 2, 2) covariances of the time-correlated errors of the tracked corners [m^2]."""
    variance = np.array([track.corner.error.variance for track in tracks]).reshape(-1, 2)
    return np.asarray(rotated(variance, np.array([track.heading for track in tracks])))


def velocities(tracks: Sequence[Track]) -> Floats:
    """(T, 2) velocities [m/s]."""
    return np.reshape([track.corner.velocity for track in tracks], (-1, 2))


def within(points: Floats, tracks: Sequence[Track]) -> Bools:
    """(P, T) mask of points (P, 2) inside the likely parts of tracks."""
    likely = np.reshape([track.likely_size for track in tracks], (-1, 2))
    return inside(points, *from_corners(tracks, likely))


def pieces(tracks: Sequence[Track]) -> Pieces:
    """Return the seen parts of tracks."""
    seen = [track.footprint for track in tracks]
    return Pieces(
        center=np.reshape([place.center for place in seen], (-1, 2)),
        heading=np.array([place.heading for place in seen]),
        size=np.reshape([place.size for place in seen], (-1, 2)),
        velocity=velocities(tracks),
        hits=np.array([track.hits for track in tracks]),
    )


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
    corner_covariance = np.reshape([bank.covariance[:, :2, :2] for bank in filters], (count, models, 2, 2))
    return Predictions(
        position=np.reshape([bank.mean[:, :2] for bank in filters], (count, models, 2)),
        velocity=np.reshape([bank.mean[:, 2:4] for bank in filters], (count, models, 2)),
        covariance=corner_covariance + offset_covariances(tracks)[:, None],
        probability=np.reshape([track.corner.bank.probability for track in tracks], (count, models)),
        heading=np.array([track.heading for track in tracks]),
        heading_variance=np.array([track.heading_variance for track in tracks]),
        size=np.reshape([track.size for track in tracks], (count, 2)),
        known_size=np.reshape([track.known_size for track in tracks], (count, 2)),
        whole=np.array([track.seen_whole for track in tracks], dtype=np.bool_).reshape(count, 2),
        corner_sign=np.array([track.corner.sign for track in tracks], dtype=np.int64).reshape(count, 2),
    )

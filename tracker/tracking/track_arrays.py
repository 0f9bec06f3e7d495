"""Lists of tracks as arrays."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.geometry import inside
from luxloop.tracker.kernels import boxes as kernel
from luxloop.tracker.merging import Pieces
from luxloop.tracker.records import MODELS
from luxloop.tracker.tracking import vehicle_size
from luxloop.tracker.tracking.corner_error import rotated
from luxloop.tracker.tracking.filters import STATE_DIM, stacked
from luxloop.tracker.tracking.hypotheses import Predictions
from luxloop.tracker.tracking.track import Track
from luxloop.tracker.tracking.traffic_flow import TrafficFlow


class TrackedCorners(NamedTuple):
    """Tracked corners of T vehicles, odometry frame."""

    corner: Floats
    """(T, 2) [m]."""
    heading: Floats
    """(T,) of the vehicles [rad]."""
    sign: Ints
    """(T, 2) signs of the corners in the vehicles' frames."""
    velocity: Floats
    """(T, 2) [m/s], zero if the stationary model is selected."""

    def first(self, count: int) -> "TrackedCorners":
        """Return those of the first `count` vehicles."""
        return TrackedCorners(self.corner[:count], self.heading[:count], self.sign[:count], self.velocity[:count])

    def boxes(self, size: Floats) -> tuple[Floats, Floats, Floats]:
        """Return centres (T, 2) [m], headings (T,) [rad] and sizes of boxes of `size` (T, 2) [m] at these corners."""
        return kernel.centers(self.corner, self.sign, self.heading, size), self.heading, size


def tracked_corners(tracks: Sequence[Track]) -> TrackedCorners:
    """Return the tracked corners of tracks."""
    corners = [track.corner for track in tracks]
    state = np.array([corner.bank.estimate[0] for corner in corners]).reshape(-1, STATE_DIM)
    velocity = state[:, 2:4].copy()
    velocity[[corner.stationary for corner in corners]] = 0.0
    sign = np.array([corner.sign for corner in corners], dtype=np.int64).reshape(-1, 2)
    return TrackedCorners(state[:, :2].copy(), np.array([track.heading for track in tracks]), sign, velocity)


def sizes(tracks: Sequence[Track]) -> Floats:
    """(T, 2) lengths and widths [m], unseen parts from priors."""
    return np.array([track.size for track in tracks]).reshape(-1, 2)


def seen_sizes(tracks: Sequence[Track]) -> Floats:
    """(T, 2) seen lengths and widths [m]."""
    return np.array([track.seen_size for track in tracks]).reshape(-1, 2)


def likely_sizes(tracks: Sequence[Track]) -> Floats:
    """(T, 2) parts of lengths and widths that probably exist, from the tracked corners on [m]."""
    std = np.array([track.size_std for track in tracks]).reshape(-1, 2)
    return vehicle_size.likely(seen_sizes(tracks), sizes(tracks), std)


def boxes(tracks: Sequence[Track]) -> tuple[Floats, Floats, Floats]:
    """Return centres (T, 2) [m], headings (T,) [rad] and sizes (T, 2) [m] of tracks, odometry frame."""
    return tracked_corners(tracks).boxes(sizes(tracks))


def offset_covariances(tracks: Sequence[Track]) -> Floats:
    """(T, 2, 2) covariances of the time-correlated errors of the tracked corners [m^2]."""
    variance = np.array([track.corner.error.variance for track in tracks]).reshape(-1, 2)
    return np.asarray(rotated(variance, np.array([track.heading for track in tracks])))


def within(points: Floats, tracks: Sequence[Track]) -> Bools:
    """(P, T) mask of points (P, 2) inside the likely parts of tracks."""
    return inside(points, *tracked_corners(tracks).boxes(likely_sizes(tracks)))


def pieces(tracks: Sequence[Track]) -> Pieces:
    """Return the seen parts of tracks."""
    corners = tracked_corners(tracks)
    seen = corners.boxes(seen_sizes(tracks))
    return Pieces(*seen, corners.velocity, np.array([track.hits for track in tracks]))


def flow(tracks: Sequence[Track], forward: float) -> TrafficFlow:
    """Return positions and directions of the tracks whose direction is known, beside an ego of heading `forward`."""
    known = [track for track in tracks if track.shows_direction]
    corners, ids = tracked_corners(known), np.array([track.id for track in known], dtype=np.int64)
    return TrafficFlow(ids, corners.corner, corners.heading, forward)


def predictions(tracks: Sequence[Track]) -> Predictions:
    """Return the predicted states of T tracks; T may be 0."""
    count = len(tracks)
    filters = [track.corner.bank.filters for track in tracks]
    models = len(filters[0].mean) if filters else len(MODELS)
    mean, covariance = stacked(filters)
    mean = mean.reshape(count, models, STATE_DIM)
    covariance = covariance.reshape(count, models, STATE_DIM, STATE_DIM)[:, :, :2, :2]
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

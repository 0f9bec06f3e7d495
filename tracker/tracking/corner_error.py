"""Time-correlated error of the tracked corner."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats
from tracker.bounds import require_within
from tracker.geometry import rotated_covariance, variance_along
from tracker.tracking import orientation
from tracker.tracking.track_observation import TrackObservation


@dataclass(frozen=True, slots=True)
class CornerConfig:
    """Time-correlated error of the tracked corner, constant while the view of the vehicle does not change.

    Averaging does not remove this error, and the filters follow it. It is therefore excluded from their gains and added
    to the reported covariance (the "consider" part of Schmidt 1966, for a slow error). A visible end has the error of a
    single scan, because the beams meet the same places again in the next one.
    """

    face_std_m: float = 0.045
    """Standard deviation of a visible end near by [m]: a line through the points of a bowed face lies behind its apex
    by a third of the sagitta. Real fronts and rears are bowed by 16.5 cm, flanks by 7 cm: 5.5 and 2.3 cm."""
    face_angle_std_rad: float = 0.0012
    """Its increase per metre of range [m/m]: the end of a face lies between two beams 0.25 degrees apart, which is a
    standard deviation of 0.25 / sqrt(12) degrees. Residual errors of mounts are of the same size."""
    known_std_m: float = 0.3
    """Standard deviation of an end that is a known side length away from a visible end [m]: until it is visible again,
    an unobserved acceleration of 1.5 m/s^2 displaces it by that in 0.6 s."""
    unseen_share: float = 0.5
    """Standard deviation of an end that was never visible, as a share of the length that the prior adds to the seen
    extent."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1e3, "face_std_m", "face_angle_std_rad", "known_std_m", "unseen_share")


class CornerError:
    """Variance of the time-correlated error of the tracked corner, along and across the heading.

    Parameters
    ----------
    first
        First observation of the track.
    heading
        Heading of the track [rad].
    unseen
        (2,) unseen part of length and width [m].
    """

    def __init__(self, first: TrackObservation, heading: float, unseen: Floats, config: CornerConfig) -> None:
        self._config = config
        exact = self._exact_variance(first, first.covariance, heading)
        self.variance = np.where(first.exact, exact, self._end_variance(unseen))
        """(2,) [m^2]."""

    def covariance(self, heading: float) -> Floats:
        """(2, 2) covariance of the error in the odometry frame [m^2]."""
        return rotated_covariance(self.variance, heading)

    def released(self, seen: TrackObservation, heading: float) -> Floats:
        """(2, 2) covariance of the past error that an exact observation removes [m^2].

        The filters add it to their own: the correction that follows is no motion of the vehicle.
        """
        past = self.variance - self._exact_variance(seen, seen.covariance, heading)
        return rotated_covariance(np.where(seen.exact, np.maximum(past, 0.0), 0.0), heading)

    def observe(self, seen: TrackObservation, covariance: Floats, heading: float) -> None:
        """Update by an observation; the filters used the covariance (2, 2) [m^2] for it."""
        inexact = np.maximum(self.variance, self._config.known_std_m**2)
        self.variance = np.where(seen.exact, self._exact_variance(seen, covariance, heading), inexact)

    def change_corner(self, changes: Bools, unseen: Floats) -> None:
        """Add the error of the side lengths when the tracked corner `changes` (2,) along and across."""
        self.variance = self.variance + np.where(changes, self._end_variance(unseen), 0.0)

    def turn(self, quarters: int) -> None:
        """Rename the axes for a heading turned by `quarters`."""
        self.variance = orientation.turn_size(self.variance, quarters)

    def _exact_variance(self, seen: TrackObservation, covariance: Floats, heading: float) -> Floats:
        """(2,) variance of a visible end: that of a single scan, and that of the face and of the unit's direction."""
        face_std_m = self._config.face_std_m + self._config.face_angle_std_rad * seen.range_m
        return np.asarray(variance_along(covariance, heading) + face_std_m**2)

    def _end_variance(self, unseen: Floats) -> Floats:
        """(2,) variance of one end of each side when the other end is known [m^2]."""
        return np.square(np.maximum(self._config.known_std_m, self._config.unseen_share * unseen))

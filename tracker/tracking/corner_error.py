"""Time-correlated error of the tracked corner."""

from dataclasses import dataclass

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.bounds import require_within
from luxloop.tracker.geometry import rotated_covariance, variance_along
from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.kernels import corner_error as kernel
from luxloop.tracker.tracking.track_observation import TrackObservation


@dataclass(frozen=True, slots=True)
class CornerConfig:
    """Time-correlated error of the tracked corner, constant while the view of the vehicle does not change.

    Averaging does not remove this error, and the filters follow it. It is therefore excluded from their gains and added
    to the reported covariance (the "consider" part of Schmidt 1966, for a slow error). A visible end has the error of a
    single scan, because the beams meet the same places again in the next one.
    """

    known_std_m: float = 0.15
    """Standard deviation of an end that is a known side length away from a visible end [m]."""
    unseen_share: float = 0.5
    """Standard deviation of an end that was never visible, as a share of the length that the prior adds to the seen
    extent."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1e3, "known_std_m", "unseen_share")


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
        self.variance = np.where(first.exact, variance_along(first.covariance, heading), self._end_variance(unseen))
        """(2,) [m^2]."""
        self.least = config.known_std_m**2
        """Variance of an end that is not visible, at least [m^2]."""

    def covariance(self, heading: float) -> Floats:
        """(2, 2) covariance of the error in the odometry frame [m^2]."""
        return rotated_covariance(self.variance, heading)

    def released(self, seen: TrackObservation, heading: float) -> Floats:
        """(2, 2) covariance of the past error that an exact observation removes [m^2].

        The filters add it to their own: the correction that follows is no motion of the vehicle.
        """
        one = self.variance[None], seen.exact[None], seen.covariance[None], np.array([heading])
        return np.asarray(kernel.released(*one)[0])

    def observe(self, exact: Bools, covariance: Floats, heading: float) -> None:
        """Update by an observation with covariance (2, 2) [m^2] that is `exact` (2,) along and across."""
        one = self.variance[None], exact[None], covariance[None], np.array([heading])
        self.variance = kernel.observe(*one, self.least)[0]

    def change_corner(self, changes: Bools, unseen: Floats) -> None:
        """Add the error of the side lengths when the tracked corner `changes` (2,) along and across."""
        self.variance = self.variance + np.where(changes, self._end_variance(unseen), 0.0)

    def turn(self, quarters: int) -> None:
        """Rename the axes for a heading turned by `quarters`."""
        self.variance = orientation.turn_size(self.variance, quarters)

    def _end_variance(self, unseen: Floats) -> Floats:
        """(2,) variance of one end of each side when the other end is known [m^2]."""
        return np.square(np.maximum(self._config.known_std_m, self._config.unseen_share * unseen))

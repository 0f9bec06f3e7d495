"""Time-correlated errors of the tracked corners of T vehicles, see `luxloop.tracker.tracking.corner_error`."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.bounds import require_within
from luxloop.tracker.compiled import kernel
from luxloop.tracker.geometry import rotated_covariance, variance_along
from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.track_observation import TrackObservation


@kernel()
def variance_on(covariance: Floats, x: float, y: float) -> float:
    """Variance of a covariance (2, 2) along a unit vector x, y."""
    return float(x * x * covariance[0, 0] + 2.0 * x * y * covariance[0, 1] + y * y * covariance[1, 1])


@kernel()
def rotated(variance: Floats, heading: Floats) -> Floats:
    """(T, 2, 2) covariances with variances (T, 2) along and across headings (T,)."""
    covariance = np.empty((len(heading), 2, 2))
    for t in range(len(heading)):
        x, y = math.cos(heading[t]), math.sin(heading[t])
        along, across = variance[t]
        covariance[t, 0, 0] = x * x * along + y * y * across
        covariance[t, 1, 1] = y * y * along + x * x * across
        covariance[t, 0, 1] = covariance[t, 1, 0] = x * y * (along - across)
    return covariance


@kernel()
def released(variance: Floats, exact: Bools, covariance: Floats, heading: Floats) -> Floats:
    """(T, 2, 2) covariances of the past errors (T, 2) that observations with covariances (T, 2, 2) remove.

    They are `exact` (T, 2) along and across the headings (T,).
    """
    removed = np.zeros_like(variance)
    for t in range(len(heading)):
        x, y = math.cos(heading[t]), math.sin(heading[t])
        if exact[t, 0]:
            removed[t, 0] = max(variance[t, 0] - variance_on(covariance[t], x, y), 0.0)
        if exact[t, 1]:
            removed[t, 1] = max(variance[t, 1] - variance_on(covariance[t], -y, x), 0.0)
    return rotated(removed, heading)


@kernel()
def observe(variance: Floats, exact: Bools, covariance: Floats, heading: Floats, least: float) -> Floats:
    """(T, 2) variances after observations with covariances (T, 2, 2) that are `exact` (T, 2) along and across."""
    observed = np.empty_like(variance)
    for t in range(len(heading)):
        x, y = math.cos(heading[t]), math.sin(heading[t])
        observed[t, 0] = variance_on(covariance[t], x, y) if exact[t, 0] else max(variance[t, 0], least)
        observed[t, 1] = variance_on(covariance[t], -y, x) if exact[t, 1] else max(variance[t, 1], least)
    return observed


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
        return np.asarray(released(*one)[0])

    def observe(self, exact: Bools, covariance: Floats, heading: float) -> None:
        """Update by an observation with covariance (2, 2) [m^2] that is `exact` (2,) along and across."""
        one = self.variance[None], exact[None], covariance[None], np.array([heading])
        self.variance = observe(*one, self.least)[0]

    def change_corner(self, changes: Bools, unseen: Floats) -> None:
        """Add the error of the side lengths when the tracked corner `changes` (2,) along and across."""
        self.variance = self.variance + np.where(changes, self._end_variance(unseen), 0.0)

    def turn(self, quarters: int) -> None:
        """Rename the axes for a heading turned by `quarters`."""
        self.variance = orientation.turn_size(self.variance, quarters)

    def _end_variance(self, unseen: Floats) -> Floats:
        """(2,) variance of one end of each side when the other end is known [m^2]."""
        return np.square(np.maximum(self._config.known_std_m, self._config.unseen_share * unseen))

"""Heading of one tracked vehicle: a Kalman filter of heading and yaw rate, and the choice of the front."""

import numpy as np

from tracker.arrays import Bools, Floats
from tracker.geometry import QUARTER, wrap
from tracker.tracking import orientation
from tracker.tracking.filters import Step, heading_filter
from tracker.tracking.track_config import TrackConfig
from tracker.tracking.track_observation import TrackObservation


class HeadingEstimator:
    """Estimate of heading and yaw rate that rejects outliers and resolves the quarter-turn ambiguity of rectangles.

    Parameters
    ----------
    first
        First observation of the track.
    position
        (2,) tracked corner [m].
    forward
        Heading of the ego [rad], the prior for the direction of a vehicle that has not moved yet.
    """

    def __init__(self, first: TrackObservation, position: Floats, forward: float, config: TrackConfig) -> None:
        self._config = config
        self._filter = heading_filter(first.heading, first.heading_variance, config.filters)
        self._rejections = 0
        self._forward = forward
        self._oriented = False
        self._votes = 0
        self._contradicted_from = position
        """(2,) tracked corner when the motion last agreed with the heading [m]."""
        self.oriented_hits = 0
        """Observations since the direction of motion confirmed the heading."""

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        return float(self._filter.mean[0, 0])

    @property
    def state(self) -> tuple[Floats, Floats]:
        """Heading and yaw rate (2,), and their covariance (2, 2)."""
        return self._filter.mean[0], self._filter.covariance[0]

    def predict(self, step: Step, turning: bool) -> None:
        """Move on by one time step; the yaw rate of a vehicle that is not `turning` is set to zero."""
        if not turning:
            self._filter.mean[0, 1] = 0.0
        self._filter.predict(step)

    def observe(self, heading: float, variance: float) -> None:
        """Update by a measured heading [rad] with a variance [rad^2], unless the gate rejects it.

        The filter restarts at the measurement after more than `heading_rejections_max` rejections in a row.
        """
        self.oriented_hits += self._oriented
        life, residual = self._config.life, heading - self.heading
        innovation_std = np.sqrt(self._filter.covariance[0, 0, 0] + variance)
        if abs(residual) > life.heading_gate_sigma * innovation_std:
            self._rejections += 1
            if self._rejections <= life.heading_rejections_max:
                return
            self._filter.mean[0] = heading, 0.0
            residual = 0.0
        self._rejections = 0
        self._filter.correct(np.array([[residual]]), np.array([[variance]]))
        self._filter.mean[0, 0] = wrap(self.heading)

    def turns_to_front(self, course: float | None, position: Floats, seen_size: Floats, seen_whole: Bools) -> int:
        """Quarter turns from the heading to the front of the vehicle; 0 until the contradiction lasts long enough.

        Parameters
        ----------
        course
            Direction of motion [rad], None for a vehicle that may be stationary.
        position
            (2,) tracked corner [m].
        seen_size
            (2,) seen length and width [m].
        seen_whole
            (2,) mask of sides that were seen from end to end.
        """
        if course is None:
            self._contradicted_from = position
            return self._turns_by_size(seen_size, seen_whole)
        return self._turns_by_course(course, position, seen_size)

    def turn(self, quarters: int, position: Floats) -> None:
        """Turn the heading by `quarters`, at the tracked corner (2,) [m]; evidence for another turn starts again."""
        self._filter.mean[0, 0] = wrap(self.heading + quarters * QUARTER)
        self._votes, self._contradicted_from = 0, position

    def shift(self, offset: Floats) -> None:
        """Account for a tracked point that moves by (2,) [m] to another place on the vehicle."""
        self._contradicted_from = self._contradicted_from + offset

    def _turns_by_size(self, seen_size: Floats, seen_whole: Bools) -> int:
        """Quarter turns by the seen size; motion has precedence, unless the vehicle is wider than any."""
        config, quarters = self._config.orientation, 0
        if not self._oriented or seen_size[1] > config.width_max_m:
            quarters = orientation.by_size(self.heading, seen_size, seen_whole, self._forward, config)
        self._votes = self._votes + 1 if quarters else 0
        return quarters if self._votes >= config.votes else 0

    def _turns_by_course(self, course: float, position: Floats, seen_size: Floats) -> int:
        """Quarter turns by the direction of motion."""
        quarters = orientation.by_course(self.heading, course)
        if quarters == 0:
            self._contradicted_from, self._oriented = position, True
            return 0
        travelled = np.hypot(*(position - self._contradicted_from))
        if travelled > orientation.way_needed(quarters, seen_size, self._config.orientation):
            self._oriented = True
            return quarters
        return 0

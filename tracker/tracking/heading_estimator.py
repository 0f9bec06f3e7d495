"""Heading of one tracked vehicle: a Kalman filter of heading and yaw rate, and the choice of the front."""

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.geometry import QUARTER
from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.correlated_views import correlated_sum
from luxloop.tracker.tracking.filters import Motion
from luxloop.tracker.tracking.heading_filters import AdaptiveHeading, PaperHeading
from luxloop.tracker.tracking.orientation import Course
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_observation import TrackObservation


class HeadingEstimator:
    """Estimate of heading and yaw rate that rejects outliers and resolves the quarter-turn ambiguity of rectangles.

    Parameters
    ----------
    first
        First observation of the track.
    position
        (2,) tracked corner [m].
    """

    def __init__(self, first: TrackObservation, position: Floats, config: TrackConfig) -> None:
        self._config = config
        self._filter = new_filter(first, config)
        self.oriented = False
        """True once the direction of motion has confirmed the heading."""
        self._shape_sum, self._views = 0.0, 0
        """Sum of the views' log-odds that the length is along the heading, and their number."""
        self._contradicted_from = position
        """(2,) tracked corner when the motion last agreed with the heading [m]."""

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        return self._filter.heading

    @property
    def variance(self) -> float:
        """Variance of the heading [rad^2]."""
        return self._filter.heading_variance

    @property
    def state(self) -> tuple[Floats, Floats]:
        """Heading and yaw rate (2,), and their covariance (2, 2)."""
        return self._filter.state

    @property
    def yaw_rate(self) -> tuple[float, float]:
        """Yaw rate that moves the corner [rad/s] and its variance [rad^2/s^2]; both zero for the paper's filter."""
        return self._filter.yaw_rate

    def predict(self, motion: Motion, speed_mps: float, turning: bool) -> None:
        """Move on by one time step, at a speed [m/s]; the paper's filter turns only if the vehicle is `turning`."""
        self._filter.predict(motion, speed_mps, turning)

    def observe(self, heading: float, variance: float) -> None:
        """Update by a measured heading [rad] with a variance [rad^2]."""
        self._filter.observe(heading, variance)

    @property
    def length_log_odds(self) -> float:
        """Log-odds by shape that the length of the vehicle is along the heading."""
        return correlated_sum(self._shape_sum, self._views, self._config.orientation.view_correlation)

    def observe_sides(self, size: Floats, whole: Bools) -> None:
        """Count a view of extents (2,) along and across the heading [m], `whole` (2,) if truncated at neither end."""
        self._shape_sum += orientation.shape_log_odds(size, whole, self._config.orientation)
        self._views += 1

    def turns_to_front(self, course: Course | None, position: Floats, seen_size: Floats) -> int:
        """Quarter turns from the heading to the direction of motion; 0 until the contradiction lasts long enough.

        Parameters
        ----------
        course
            Direction of motion, None for a vehicle that may be stationary.
        position
            (2,) tracked corner [m].
        seen_size
            (2,) seen length and width [m].
        """
        if course is None:
            self._contradicted_from = position
            return 0
        return self._turns_by_course(course, position, seen_size)

    def turn(self, quarters: int, position: Floats) -> None:
        """Turn the heading by `quarters`, at the tracked corner (2,) [m]."""
        self._filter.turn(quarters * QUARTER)
        self._contradicted_from = position
        if quarters % 2:
            self._shape_sum = -self._shape_sum

    def shift(self, offset: Floats) -> None:
        """Account for a tracked point that moves by (2,) [m] to another place on the vehicle."""
        self._contradicted_from = self._contradicted_from + offset

    def _turns_by_course(self, course: Course, position: Floats, seen_size: Floats) -> int:
        """Quarter turns by the direction of motion."""
        quarters = orientation.by_course(self.heading, course.direction)
        if quarters == 0:
            self._contradicted_from, self.oriented = position, True
            self._filter.support(course.direction, course.variance)
            return 0
        travelled = abs(complex(*(position - self._contradicted_from).tolist()))
        if travelled > orientation.way_needed(quarters, seen_size, self._config.orientation):
            self.oriented = True
            return quarters
        return 0


def new_filter(first: TrackObservation, config: TrackConfig) -> PaperHeading | AdaptiveHeading:
    """Return the filter of `FilterConfig.heading`, at the first observation."""
    life, measured = config.life, (first.heading, first.heading_variance, config.filters)
    if config.filters.heading == "paper":
        return PaperHeading(*measured, life.heading_gate_sigma, life.heading_rejections_max)
    return AdaptiveHeading(*measured)

"""Heading of one tracked vehicle: filters of heading and yaw rate, and the choice of the front."""

import math

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.geometry import QUARTER, wrap
from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.confirmation import correlated_sum
from luxloop.tracker.tracking.filters import INITIAL_YAW_RATE_STD_RADPS, Motion, heading_filter
from luxloop.tracker.tracking.orientation import Course
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_observation import TrackObservation

YAW_RATE_TIME_S = 1.0
"""Correlation time of the yaw rate [s]: half of a turn at a crossing."""

CURVATURE_STD_PER_M = 0.1
"""Standard deviation of the curvature [1/m]: cars turn on 5 m at least, two standard deviations."""

LATERAL_ACCELERATION_STD_MPS2 = 4.0
"""Standard deviation of the lateral acceleration [m/s^2]: the grip of dry roads, 8, is two of them."""

HEADING_DRIFT_DENSITY_RAD2PS = 1e-4
"""The visible outline of a body, and with it the fit, turns by about half a degree in a second
[rad^2/s]."""

COURSE_TIME_S = 0.5
"""Time for which the error of the direction of motion lasts, the memory of the velocity filter [s]."""

SLIP_STD_RAD = 0.02
"""Standard deviation of the angle between heading and motion of the rear axle, by side slip [rad]."""

HEADING_OUTLIER_SHARE = 0.05
"""Share of headings that are outliers, as arcs fitted as sides: 2 of 55 recorded vehicles."""

HEADING_RESTART_S = 0.5
"""Time for which headings must agree with one another, and not with the track, to replace its
heading [s]."""

HEADING_GATE_SIGMA = 4.0
"""`PaperHeading`: gate on the heading innovation, in standard deviations."""

HEADING_REJECTIONS_MAX = 8
"""`PaperHeading`: number of rejected headings in a row after which the next one is accepted."""

VIEW_CORRELATION = 0.3
"""Correlation of successive views of a stationary vehicle: many equal views have the evidence of three."""

STILL_MPS = 1e-3
"""Smallest speed that limits a yaw rate [m/s]."""


class PaperHeading:
    """Heading filter (9): rejects outliers by a gate, and restarts after too many in a row.

    Parameters
    ----------
    heading, variance
        First measurement [rad], [rad^2].
    """

    def __init__(self, heading: float, variance: float) -> None:
        self._filter = heading_filter(heading, variance)
        self._rejections = 0

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        return float(self._filter.mean[0, 0])

    @property
    def heading_variance(self) -> float:
        """[rad^2]."""
        return self._filter.covariance.item(0, 0, 0)

    @property
    def state(self) -> tuple[Floats, Floats]:
        """Heading and yaw rate (2,), and their covariance (2, 2)."""
        return self._filter.mean[0], self._filter.covariance[0]

    @property
    def yaw_rate(self) -> tuple[float, float]:
        """Yaw rate that moves the corner [rad/s] and its variance: zero, as the paper's models do not couple it."""
        return 0.0, 0.0

    def predict(self, motion: Motion, speed_mps: float, turning: bool) -> None:
        """Move on by one time step; the yaw rate of a vehicle that is not `turning` is set to zero."""
        del speed_mps
        if not turning:
            self._filter.mean[0, 1] = 0.0
        self._filter.predict(motion.heading)

    def observe(self, heading: float, variance: float) -> None:
        """Update by a measured heading [rad] with a variance [rad^2], unless the gate rejects it."""
        residual = heading - float(self._filter.mean[0, 0])
        innovation_std = np.sqrt(self._filter.covariance[0, 0, 0] + variance)
        if abs(residual) > HEADING_GATE_SIGMA * innovation_std:
            self._rejections += 1
            if self._rejections <= HEADING_REJECTIONS_MAX:
                return
            self._filter.mean[0] = heading, 0.0
            residual = 0.0
        self._rejections = 0
        self._filter.correct(np.array([[residual]]), np.array([[variance]]))
        self._filter.mean[0, 0] = wrap(float(self._filter.mean[0, 0]))

    def support(self, course: float, variance: float) -> None:
        """Ignore the direction of motion, which the paper uses for the choice of the front only."""

    def turn(self, angle: float) -> None:
        """Turn the heading by an angle [rad]."""
        self._filter.mean[0, 0] = wrap(float(self._filter.mean[0, 0]) + angle)


class TurnFilter:
    """Kalman filter of heading and yaw rate whose noise follows from the speed, with outliers by their probability.

    The yaw rate is a Gauss-Markov process (Singer 1970). Its standard deviation is that of the curvature of roads times
    the speed, limited by the lateral acceleration: a stationary vehicle does not turn, a fast one hardly. A measurement
    is an outlier with a prior probability, and then uniform over a quarter turn. The update is the mean over both cases
    with the spread between them (probabilistic data association with one measurement, Bar-Shalom and Tse 1975), so that
    the covariance grows with each measurement in doubt.
    """

    def __init__(self, heading: float, variance: float, yaw_rate: float) -> None:
        self.heading, self.yaw_rate = heading, yaw_rate
        self.variance = (variance, 0.0, INITIAL_YAW_RATE_STD_RADPS**2)
        """Of the heading, of both, and of the yaw rate."""

    def predict(self, dt: float, speed_mps: float) -> None:
        """Move on by `dt` [s] at a speed [m/s]."""
        p, c, r = self.variance
        tau, std = YAW_RATE_TIME_S, yaw_rate_std(speed_mps)
        keeps = math.exp(-dt / tau)
        gained = tau * (1.0 - keeps)
        across = max(2.0 * dt / tau - 3.0 + 4.0 * keeps - keeps**2, 0.0) * (std * tau) ** 2
        self.heading += gained * self.yaw_rate
        self.yaw_rate *= keeps
        self.variance = (
            p + 2.0 * gained * c + gained**2 * r + across + HEADING_DRIFT_DENSITY_RAD2PS * dt,
            keeps * (c + gained * r) + std**2 * tau * (1.0 - keeps) ** 2,
            keeps**2 * r + std**2 * (1.0 - keeps**2),
        )

    def observe(self, heading: float, variance: float) -> float:
        """Update by a measured heading [rad] with a variance [rad^2]; return the probability that it is an outlier."""
        (p, c, r), residual, share = self.variance, heading - self.heading, HEADING_OUTLIER_SHARE
        innovation = p + variance
        density = math.exp(-0.5 * residual**2 / innovation) / math.sqrt(2.0 * math.pi * innovation)
        outlier = share / QUARTER / (share / QUARTER + (1.0 - share) * density)
        good, gain, gain_rate = 1.0 - outlier, p / innovation, c / innovation
        self.heading = wrap(self.heading + good * gain * residual)
        self.yaw_rate += good * gain_rate * residual
        spread = good * (outlier * residual**2 - innovation)
        self.variance = (p + spread * gain**2, c + spread * gain * gain_rate, r + spread * gain_rate**2)
        return outlier


class AdaptiveHeading:
    """Turn filter, and a second one that takes over if it explains the measurements that the first cannot.

    The second filter starts at a measurement that is likely an outlier, and is discarded when the first one explains a
    measurement again. After `HEADING_RESTART_S` it replaces the first, with its yaw rate and its covariance.
    """

    def __init__(self, heading: float, variance: float) -> None:
        self._filter = TurnFilter(heading, variance, 0.0)
        self._second: TurnFilter | None = None
        self._second_s = 0.0
        self._dt = 0.0

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        return self._filter.heading

    @property
    def heading_variance(self) -> float:
        """[rad^2]."""
        return self._filter.variance[0]

    @property
    def state(self) -> tuple[Floats, Floats]:
        """Heading and yaw rate (2,), and their covariance (2, 2)."""
        own = self._filter
        p, c, r = own.variance
        return np.array([own.heading, own.yaw_rate]), np.array([[p, c], [c, r]])

    @property
    def yaw_rate(self) -> tuple[float, float]:
        """Yaw rate [rad/s] and its variance [rad^2/s^2]."""
        return self._filter.yaw_rate, self._filter.variance[2]

    def predict(self, motion: Motion, speed_mps: float, turning: bool) -> None:
        """Move on by one time step at a speed [m/s]; a vehicle turns in every model of motion."""
        del turning
        self._dt = motion.dt
        self._filter.predict(motion.dt, speed_mps)
        if self._second is not None:
            self._second.predict(motion.dt, speed_mps)
            self._second_s += motion.dt

    def observe(self, heading: float, variance: float) -> None:
        """Update by a measured heading [rad], modulo a quarter turn, with a variance [rad^2]."""
        heading = near(heading, self._filter.heading)
        yaw_rate = self._filter.yaw_rate
        if self._filter.observe(heading, variance) <= 0.5:
            self._second = None
        elif self._second is None or self._second.observe(near(heading, self._second.heading), variance) > 0.5:
            self._second, self._second_s = TurnFilter(heading, variance, yaw_rate), 0.0
        elif self._second_s >= HEADING_RESTART_S:
            self._filter, self._second = self._second, None

    def support(self, course: float, variance: float) -> None:
        """Update by the direction of motion [rad] with a variance [rad^2].

        It is a mean over the memory of the velocity filter, so that its error lasts for `COURSE_TIME_S`, and it lags in
        a turn. The variance is that of an independent direction in each scan with the same information.
        """
        heading = self._filter.heading
        lag = COURSE_TIME_S * self._filter.yaw_rate
        repeated = COURSE_TIME_S / self._dt if self._dt else 1.0
        total = variance + lag**2 + SLIP_STD_RAD**2
        self._filter.observe(near(course, heading), total * max(repeated, 1.0))

    def turn(self, angle: float) -> None:
        """Turn the heading by an angle [rad]."""
        self._filter.heading = wrap(self._filter.heading + angle)
        self._second = None


def near(heading: float, other: float) -> float:
    """Return the heading, modulo a quarter turn, that is nearest to another one [rad]."""
    return heading + QUARTER * round((other - heading) / QUARTER)


def yaw_rate_std(speed_mps: float) -> float:
    """Standard deviation of the yaw rate of a vehicle at a speed [rad/s]: by the curvature or by the grip."""
    by_grip = LATERAL_ACCELERATION_STD_MPS2 / max(speed_mps, STILL_MPS)
    return min(CURVATURE_STD_PER_M * speed_mps, by_grip)


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
        return correlated_sum(self._shape_sum, self._views, VIEW_CORRELATION)

    def observe_sides(self, size: Floats, whole: Bools) -> None:
        """Count a view of extents (2,) along and across the heading [m], `whole` (2,) if truncated at neither end."""
        self._shape_sum += orientation.shape_log_odds(size, whole)
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
        if travelled > orientation.way_needed(quarters, seen_size):
            self.oriented = True
            return quarters
        return 0


def new_filter(first: TrackObservation, config: TrackConfig) -> PaperHeading | AdaptiveHeading:
    """Return the filter of `FilterConfig.heading`, at the first observation."""
    measured = first.heading, first.heading_variance
    if config.filters.heading == "paper":
        return PaperHeading(*measured)
    return AdaptiveHeading(*measured)

"""Heading of the tracked vehicles: filters of heading and yaw rate, and the choice of the front."""

import math
from typing import NamedTuple

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats
from luxloop.tracker.geometry import QUARTER, wrap
from luxloop.tracker.tracking import orientation
from luxloop.tracker.tracking.filters import (
    INITIAL_YAW_RATE_STD_RADPS,
    FilterConfig,
    Motion,
    correct_rows,
    predict_rows,
)
from luxloop.tracker.tracking.orientation import Course
from luxloop.tracker.tracking.track_table import TrackTable

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

HEADING_OUTLIER_FRACTION = 0.05
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
    """Heading filter (9): rejects outliers by a gate, and restarts after too many in a row."""

    def yaw_rate(self, tracks: TrackTable, t: int) -> tuple[float, float]:
        """Yaw rate that moves the corner [rad/s] and its variance: zero, as the paper's models do not couple it."""
        del tracks, t
        return 0.0, 0.0

    def predict(self, tracks: TrackTable, motion: Motion, speed_mps: Floats, turning: Bools) -> None:
        """Move on by one time step; the yaw rate of a vehicle that is not `turning` (T,) is set to zero."""
        del speed_mps
        tracks.yaw[~turning, 1] = 0.0
        step = motion.heading
        tracks.yaw, tracks.yaw_covariance = predict_rows(tracks.yaw, tracks.yaw_covariance, step.transition, step.noise)

    def observe(self, tracks: TrackTable, t: int, heading: float, variance: float) -> None:
        """Update by a measured heading [rad] with a variance [rad^2], unless the gate rejects it."""
        innovation = heading - tracks.yaw.item(t, 0)
        if abs(innovation) > HEADING_GATE_SIGMA * math.sqrt(tracks.yaw_covariance.item(t, 0, 0) + variance):
            tracks.rejected_headings[t] += 1
            if tracks.rejected_headings[t] <= HEADING_REJECTIONS_MAX:
                return
            tracks.yaw[t] = heading, 0.0
            innovation = 0.0
        tracks.rejected_headings[t] = 0
        measured = np.array([[innovation]]), np.array([[[variance]]])
        yaw, covariance = correct_rows(tracks.yaw[t : t + 1], tracks.yaw_covariance[t : t + 1], *measured)
        tracks.yaw[t], tracks.yaw_covariance[t] = yaw[0], covariance[0]
        tracks.yaw[t, 0] = wrap(tracks.yaw.item(t, 0))

    def support(self, tracks: TrackTable, t: int, course: Course, dt: float) -> None:
        """Ignore the direction of motion, which the paper uses for the choice of the front only."""


class Turn(NamedTuple):
    """Heading and yaw rate of one vehicle, and their covariance."""

    heading: float
    yaw_rate: float
    variance: tuple[float, float, float]
    """Of the heading, of both, and of the yaw rate."""

    @classmethod
    def start(cls, heading: float, variance: float, yaw_rate: float) -> "Turn":
        """Return the state at the first measurement [rad] with a variance [rad^2]."""
        return cls(heading, yaw_rate, (variance, 0.0, INITIAL_YAW_RATE_STD_RADPS**2))


def predicted(turn: Turn, dt: float, speed_mps: float) -> Turn:
    """Return heading and yaw rate of a vehicle `dt` [s] later, at a speed [m/s].

    The yaw rate is a Gauss-Markov process (Singer 1970). Its standard deviation is that of the curvature of roads times
    the speed, limited by the lateral acceleration: a stationary vehicle does not turn, a fast one hardly.
    """
    p, c, r = turn.variance
    tau, std = YAW_RATE_TIME_S, yaw_rate_std(speed_mps)
    keeps = elementary.exp(-dt / tau)
    gained = tau * (1.0 - keeps)
    across = max(2.0 * dt / tau - 3.0 + 4.0 * keeps - keeps * keeps, 0.0) * std * std * tau * tau
    variance = (
        p + 2.0 * gained * c + gained * gained * r + across + HEADING_DRIFT_DENSITY_RAD2PS * dt,
        keeps * (c + gained * r) + std * std * tau * (1.0 - keeps) * (1.0 - keeps),
        keeps * keeps * r + std * std * (1.0 - keeps * keeps),
    )
    return Turn(turn.heading + gained * turn.yaw_rate, turn.yaw_rate * keeps, variance)


def corrected(turn: Turn, heading: float, variance: float) -> tuple[Turn, float]:
    """Return the state after a measured heading [rad] with a variance [rad^2], and the probability of an outlier.

    A measurement is an outlier with a prior probability, and then uniform over a quarter turn. The update is the mean
    over both cases with the spread between them (probabilistic data association with one measurement, Bar-Shalom and
    Tse 1975), so that the covariance grows with each measurement in doubt.
    """
    (p, c, r), residual, share = turn.variance, heading - turn.heading, HEADING_OUTLIER_FRACTION
    innovation = p + variance
    density = elementary.exp(-0.5 * residual * residual / innovation) / math.sqrt(2.0 * math.pi * innovation)
    outlier = share / QUARTER / (share / QUARTER + (1.0 - share) * density)
    good, gain, gain_rate = 1.0 - outlier, p / innovation, c / innovation
    spread = good * (outlier * residual * residual - innovation)
    after = Turn(
        wrap(turn.heading + good * gain * residual),
        turn.yaw_rate + good * gain_rate * residual,
        (p + spread * gain * gain, c + spread * gain * gain_rate, r + spread * gain_rate * gain_rate),
    )
    return after, outlier


class AdaptiveHeading:
    """Heading filter whose noise follows from the speed, with outliers weighed by their probability.

    A second filter takes over if it explains the measurements that the first cannot. It starts at a measurement that is
    likely an outlier, and is discarded when the first one explains a measurement again. After `HEADING_RESTART_S` it
    replaces the first, with its yaw rate and its covariance.
    """

    def yaw_rate(self, tracks: TrackTable, t: int) -> tuple[float, float]:
        """Yaw rate [rad/s] and its variance [rad^2/s^2]."""
        return tracks.yaw.item(t, 1), tracks.yaw_covariance.item(t, 1, 1)

    def predict(self, tracks: TrackTable, motion: Motion, speed_mps: Floats, turning: Bools) -> None:
        """Move on by one time step at speeds (T,) [m/s]; a vehicle turns in every model of motion."""
        del turning
        second = np.isfinite(tracks.second_yaw[:, 0]).tolist()
        for t, speed in enumerate(speed_mps.tolist()):
            write(tracks.yaw, tracks.yaw_covariance, t, predicted(read(tracks, t), motion.dt, speed))
            if second[t]:
                write(
                    tracks.second_yaw, tracks.second_covariance, t, predicted(read_second(tracks, t), motion.dt, speed)
                )
        tracks.second_s += motion.dt

    def observe(self, tracks: TrackTable, t: int, heading: float, variance: float) -> None:
        """Update by a measured heading [rad], modulo a quarter turn, with a variance [rad^2]."""
        first = read(tracks, t)
        heading = near(heading, first.heading)
        after, outlier = corrected(first, heading, variance)
        write(tracks.yaw, tracks.yaw_covariance, t, after)
        if outlier <= 0.5:
            tracks.second_yaw[t] = np.nan
            return
        second, second_outlier = Turn.start(heading, variance, first.yaw_rate), 1.0
        if math.isfinite(tracks.second_yaw.item(t, 0)):
            old = read_second(tracks, t)
            explained, second_outlier = corrected(old, near(heading, old.heading), variance)
        if second_outlier > 0.5:
            write(tracks.second_yaw, tracks.second_covariance, t, second)
            tracks.second_s[t] = 0.0
        elif tracks.second_s[t] >= HEADING_RESTART_S:
            write(tracks.yaw, tracks.yaw_covariance, t, explained)
            tracks.second_yaw[t] = np.nan
        else:
            write(tracks.second_yaw, tracks.second_covariance, t, explained)

    def support(self, tracks: TrackTable, t: int, course: Course, dt: float) -> None:
        """Update by the direction of motion, after a step of `dt` [s].

        It is a mean over the memory of the velocity filter, so that its error lasts for `COURSE_TIME_S`, and it lags in
        a turn. The variance is that of an independent direction in each scan with the same information.
        """
        turn = read(tracks, t)
        lag = COURSE_TIME_S * turn.yaw_rate
        repeated = COURSE_TIME_S / dt if dt else 1.0
        total = course.variance + lag**2 + SLIP_STD_RAD**2
        after, _ = corrected(turn, near(course.direction, turn.heading), total * max(repeated, 1.0))
        write(tracks.yaw, tracks.yaw_covariance, t, after)


HeadingFilter = PaperHeading | AdaptiveHeading


def heading_filter(config: FilterConfig) -> HeadingFilter:
    """Return the filter of `FilterConfig.heading`."""
    return PaperHeading() if config.heading == "paper" else AdaptiveHeading()


def read(tracks: TrackTable, t: int) -> Turn:
    """Return heading and yaw rate of a track."""
    (heading, yaw_rate), ((p, c), (_, r)) = tracks.yaw[t].tolist(), tracks.yaw_covariance[t].tolist()
    return Turn(heading, yaw_rate, (p, c, r))


def read_second(tracks: TrackTable, t: int) -> Turn:
    """Return the state of the filter that may take over."""
    (heading, yaw_rate), ((p, c), (_, r)) = tracks.second_yaw[t].tolist(), tracks.second_covariance[t].tolist()
    return Turn(heading, yaw_rate, (p, c, r))


def write(yaw: Floats, covariance: Floats, t: int, turn: Turn) -> None:
    """Write heading and yaw rate into row `t` of yaw (T, 2) and covariance (T, 2, 2)."""
    p, c, r = turn.variance
    yaw[t], covariance[t] = (turn.heading, turn.yaw_rate), ((p, c), (c, r))


def near(heading: float, other: float) -> float:
    """Return the heading, modulo a quarter turn, that is nearest to another one [rad]."""
    return heading + QUARTER * round((other - heading) / QUARTER)


def yaw_rate_std(speed_mps: float) -> float:
    """Standard deviation of the yaw rate of a vehicle at a speed [rad/s]: by the curvature or by the grip."""
    by_grip = LATERAL_ACCELERATION_STD_MPS2 / max(speed_mps, STILL_MPS)
    return min(CURVATURE_STD_PER_M * speed_mps, by_grip)


def observe_sides(tracks: TrackTable, t: int, size: Floats, untruncated: Bools) -> None:
    """Count a view of extents (2,) along and across the heading [m], with a mask (2,) of untruncated sides."""
    tracks.axis_evidence[t] += orientation.shape_log_odds(size, untruncated)
    tracks.axis_views[t] += 1


def length_log_odds(tracks: TrackTable, t: int) -> float:
    """Return the log-odds by shape that the length of a vehicle is along its heading."""
    return orientation.correlated_sum(tracks.axis_evidence.item(t), tracks.axis_views.item(t), VIEW_CORRELATION)


def turns_to_front(tracks: TrackTable, t: int, course: Course | None, filtered: HeadingFilter, dt: float) -> int:
    """Return the quarter turns from a heading to the direction of motion; 0 until the contradiction lasts long enough.

    The `course` is None for a vehicle that may be stationary.
    """
    position = tracks.estimate[t, :2]
    quarters = 0 if course is None else orientation.by_course(tracks.yaw.item(t, 0), course.direction)
    if course is None or quarters == 0:
        tracks.contradicted_from[t] = position
        if course is not None:
            tracks.oriented[t] = True
            filtered.support(tracks, t, course, dt)
        return 0
    travelled = abs(complex(*(position - tracks.contradicted_from[t]).tolist()))
    if travelled > orientation.way_needed(quarters, tracks.visible_size[t]):
        tracks.oriented[t] = True
        return quarters
    return 0


def turn_heading(tracks: TrackTable, t: int, quarters: int) -> None:
    """Turn a heading by quarters."""
    tracks.yaw[t, 0] = wrap(tracks.yaw.item(t, 0) + quarters * QUARTER)
    tracks.second_yaw[t] = np.nan
    tracks.contradicted_from[t] = tracks.estimate[t, :2]
    if quarters % 2:
        tracks.axis_evidence[t] *= -1.0

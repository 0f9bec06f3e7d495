"""Tracked corner of each vehicle: its time-correlated error, its motion, and the change to another corner."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.bounds import require_within
from luxloop.tracker.geometry import mahalanobis, rotate_one, rotated_covariance
from luxloop.tracker.tracking.filters import ORDERS, FilterConfig, moved

if TYPE_CHECKING:
    from luxloop.tracker.tracking.track_table import TrackTable


@kernel()
def variance_on(covariance: Floats, x: float, y: float) -> float:
    """Variance of a covariance (2, 2) along a unit vector x, y."""
    return float(x * x * covariance[0, 0] + 2.0 * x * y * covariance[0, 1] + y * y * covariance[1, 1])


@kernel()
def rotated(variance: Floats, heading: Floats) -> Floats:
    """(T, 2, 2) covariances with variances (T, 2) along and across headings (T,)."""
    covariance = np.empty((len(heading), 2, 2))
    for t in range(len(heading)):
        x, y = elementary.cos(heading[t]), elementary.sin(heading[t])
        along, across = variance[t]
        covariance[t, 0, 0] = x * x * along + y * y * across
        covariance[t, 1, 1] = y * y * along + x * x * across
        covariance[t, 0, 1] = covariance[t, 1, 0] = x * y * (along - across)
    return covariance


@kernel()
def released(variance: Floats, end_visible: Bools, covariance: Floats, heading: Floats) -> Floats:
    """(T, 2, 2) covariances of the past errors (T, 2) that observations with covariances (T, 2, 2) remove.

    They are exact where an end (T, 2) is visible, along and across the headings (T,).
    """
    removed = np.zeros_like(variance)
    for t in range(len(heading)):
        x, y = elementary.cos(heading[t]), elementary.sin(heading[t])
        if end_visible[t, 0]:
            removed[t, 0] = max(variance[t, 0] - variance_on(covariance[t], x, y), 0.0)
        if end_visible[t, 1]:
            removed[t, 1] = max(variance[t, 1] - variance_on(covariance[t], -y, x), 0.0)
    return rotated(removed, heading)


@kernel()
def observe(variance: Floats, end_visible: Bools, covariance: Floats, heading: Floats, least: float) -> Floats:
    """(T, 2) variances after observations with covariances (T, 2, 2), exact on axes with a visible end (T, 2)."""
    observed = np.empty_like(variance)
    for t in range(len(heading)):
        x, y = elementary.cos(heading[t]), elementary.sin(heading[t])
        observed[t, 0] = variance_on(covariance[t], x, y) if end_visible[t, 0] else max(variance[t, 0], least)
        observed[t, 1] = variance_on(covariance[t], -y, x) if end_visible[t, 1] else max(variance[t, 1], least)
    return observed


@dataclass(frozen=True, slots=True)
class CornerConfig:
    """Time-correlated error of the tracked corner, constant while the view of the vehicle does not change.

    Averaging does not remove this error, and the filters follow it. It is therefore excluded from their gains and added
    to the reported covariance (the "consider" part of Schmidt 1966, for a slow error). A visible end has the error of a
    single scan, because the beams meet the same places again in the next one.
    """

    known_std_m: float = 0.15
    """Standard deviation of an end that is a known side length away from a visible end [m]. Increase it if vehicles
    have sizes that the classes do not describe. Set 0 for hidden ends as certain as visible ones, as in the paper."""
    unseen_fraction: float = 0.5
    """Standard deviation of an end that was never visible, as a fraction of the length that the prior adds to the
    visible extent. Decrease it if all vehicles are of one known size. Set 0 to compare with the paper."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1e3, "known_std_m", "unseen_fraction")


def end_variance(unseen: Floats, config: CornerConfig) -> Floats:
    """(2,) variance of one end of each side when the other end is known and a part (2,) [m] was never seen [m^2]."""
    return np.asarray(np.square(np.maximum(config.known_std_m, config.unseen_fraction * unseen)))


def speeds(tracks: "TrackTable") -> Floats:
    """(T,) root mean square of the speeds [m/s], which includes their uncertainty."""
    velocity, covariance = tracks.velocity, tracks.estimate_covariance
    x, y = velocity[:, 0], velocity[:, 1]
    return np.asarray(np.sqrt(x * x + y * y + 0.5 * (covariance[:, 2, 2] + covariance[:, 3, 3])))


def corner_covariance(tracks: "TrackTable", t: int) -> Floats:
    """(2, 2) covariance of the tracked corner of a track, with its time-correlated error [m^2]."""
    error = rotated_covariance(tracks.corner_variance[t], tracks.heading.item(t))
    return np.asarray(tracks.estimate_covariance[t, :2, :2] + error)


def density(tracks: "TrackTable", t: int, innovation: Floats, noise: Floats) -> float:
    """Return the predicted density of an observation of a track at its place, over all models [1/m^2].

    Its innovations are (M, 2) [m], and its covariance is (2, 2) [m^2].
    """
    error = rotated_covariance(tracks.corner_variance[t], tracks.heading.item(t))
    squared, determinant = mahalanobis(innovation, tracks.covariance[t, :, :2, :2] + noise + error)
    each = elementwise.exp(-0.5 * squared) / (2.0 * np.pi * np.sqrt(determinant))
    return float((tracks.probability[t] * each).sum())


def shift(tracks: "TrackTable", t: int, offset: Floats, yaw_rate: float) -> None:
    """Track another point of a vehicle with a yaw rate [rad/s], (2,) [m] away from the current one."""
    change = moved(offset, yaw_rate)
    for state in (tracks.mean, tracks.independent_mean, tracks.estimate):
        state[t] += change


def change_corner(
    tracks: "TrackTable", t: int, sign: Ints, unseen: Floats, yaw_rate: float, config: CornerConfig
) -> None:
    """Track the corner of a vehicle with signs (2,), at a yaw rate [rad/s].

    The sides add the error of their parts (2,) that were never seen [m].
    """
    offset = rotate_one(0.5 * (sign - tracks.corner_sign[t]) * tracks.size[t], tracks.heading.item(t))
    shift(tracks, t, offset, yaw_rate)
    changes = sign != tracks.corner_sign[t]
    tracks.corner_variance[t] += np.where(changes, end_variance(unseen, config), 0.0)
    tracks.corner_sign[t] = sign
    tracks.contradicted_from[t] += offset


def admit_speed(tracks: "TrackTable", t: int, innovation: Floats, time_offset: float, config: FilterConfig) -> Floats:
    """Admit the speed that the second observation of a track shows; return its innovations (M, 2) [m].

    The prior of the velocity has a mean of zero. Where the vehicle moved by more than two of its standard deviations
    explain, the variance along that motion becomes the square of the speed. Both boxes were at their places at their
    own times, `time_offset` after their scans: the returned innovations, and the track, are those at the times of the
    scans.
    """
    since_s, first_offset = tracks.unobserved_s.item(t), tracks.first_offset_s.item(t)
    motion = innovation[tracks.probability[t].argmax()]
    elapsed = since_s + time_offset - first_offset
    if elapsed <= 0.0 or elementwise.hypot(*motion) <= 2.0 * config.initial_speed_std_mps * elapsed:
        return innovation
    velocity = motion / elapsed
    shift(tracks, t, -first_offset * velocity, yaw_rate=0.0)
    growth = np.kron([[since_s**2, since_s], [since_s, 1.0]], np.outer(velocity, velocity))
    moves = np.array([ORDERS[name] > 1 for name in tracks.models])
    each = moves[:, None, None] * growth
    tracks.covariance[t, :, :4, :4] += each
    tracks.independent_covariance[t, :, :4, :4] += each
    tracks.estimate_covariance[t, :4, :4] += each.max(axis=0)
    return np.asarray(innovation + (first_offset - time_offset) * velocity)

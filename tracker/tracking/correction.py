"""Correction of tracks by the boxes that were assigned to them, and the change of a track to a larger box."""

import numpy as np

from luxloop.arrays import Floats
from luxloop.tracker.geometry import rotate_one
from luxloop.tracker.tracking import corner, heading, mma, orientation, vehicle_size
from luxloop.tracker.tracking.confirmation import count_view, reacquire
from luxloop.tracker.tracking.existence import same_vehicle
from luxloop.tracker.tracking.heading import HeadingFilter, heading_filter
from luxloop.tracker.tracking.model_selection import ModelSelection
from luxloop.tracker.tracking.orientation import Course
from luxloop.tracker.tracking.prediction import from_axle
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_observation import TrackObservations
from luxloop.tracker.tracking.track_table import COASTING, TrackTable


def correct(
    tracks: TrackTable, observed: TrackObservations, selection: ModelSelection, config: TrackConfig, dt: float
) -> None:
    """Update tracks by one observation each, `dt` [s] after the last scan."""
    if not len(observed):
        return
    innovation = admit(tracks, observed, selection, config)
    correct_corners(tracks, observed, innovation, selection, config)
    for p in range(len(observed)):
        follow(tracks, observed, p, selection, config, dt)


def admit(tracks: TrackTable, observed: TrackObservations, selection: ModelSelection, config: TrackConfig) -> Floats:
    """Return the innovations (P, M, 2) of the corners [m]; the second observation of a track shows its speed.

    After a track has coasted, the observation may be of another object.
    """
    innovation = observed.innovation.copy()
    for p, t in enumerate(observed.row.tolist()):
        if tracks.status[t] == COASTING:
            expected = corner.density(tracks, t, innovation[p], observed.covariance[p])
            reacquire(
                tracks, t, same_vehicle(tracks.unobserved_s.item(t), expected, config.existence), config.confirmation
            )
        if tracks.hits[t] == 1:
            innovation[p] = corner.admit_speed(tracks, t, innovation[p], observed.time_offset.item(p), config.filters)
            selection.summarise(tracks, observed.row[p : p + 1])
    return innovation


def correct_corners(
    tracks: TrackTable,
    observed: TrackObservations,
    innovation: Floats,
    selection: ModelSelection,
    config: TrackConfig,
) -> None:
    """Score and correct the filters, and update the time-correlated errors of the corners.

    A correction of a past error by a visible end is no motion of the vehicle: the filters add it to their own before.
    """
    rows, each, yaw = observed.row, np.arange(len(observed)), tracks.yaw[observed.row, 0]
    model = tracks.model[rows]
    measured = tracks.mean[rows, model, :2] + innovation[each, model]
    errors = tracks.corner_variance[rows], observed.end_visible
    released = corner.released(*errors, observed.covariance, yaw)
    for covariance in (tracks.covariance, tracks.independent_covariance):
        covariance[rows, :, :2, :2] += released[:, None]
    noise = selection.correct(tracks, rows, innovation, observed.covariance)
    tracks.corner_variance[rows] = corner.observe(*errors, noise, yaw, config.corner.known_std_m**2)
    states = tracks.independent_mean[rows], tracks.independent_covariance[rows]
    mean, covariance, nis = mma.correct_independent(*states, measured, noise)
    tracks.independent_mean[rows], tracks.independent_covariance[rows], tracks.nis[rows] = mean, covariance, nis


def follow(
    tracks: TrackTable,
    observed: TrackObservations,
    p: int,
    selection: ModelSelection,
    config: TrackConfig,
    dt: float,
) -> None:
    """Update all but the corner, which was updated before, by observation `p`."""
    t, size, untruncated, filtered = (
        observed.row.item(p),
        observed.size[p],
        observed.untruncated[p],
        heading_filter(config.filters),
    )
    filtered.observe(tracks, t, observed.heading.item(p), observed.heading_variance.item(p))
    heading.observe_sides(tracks, t, size, untruncated)
    tracks.hits[t] += 1
    tracks.unobserved_s[t] = 0.0
    vehicle_size.observe_size(tracks, t, size, untruncated)
    sign = observed.corner_sign[p]
    if (sign != tracks.corner_sign[t]).any():
        unseen, (yaw_rate, _) = 2.0 * tracks.size_std[t], filtered.yaw_rate(tracks, t)
        corner.change_corner(tracks, t, sign, unseen, yaw_rate, config.corner)
        selection.summarise(tracks, observed.row[p : p + 1])
    count_view(tracks, t, size, untruncated, observed.flat.item(p))
    course = course_of(tracks, t, filtered)
    turn(tracks, t, heading.turns_to_front(tracks, t, course, filtered, dt))


def course_of(tracks: TrackTable, t: int, filtered: HeadingFilter) -> Course | None:
    """Return the direction of motion of the rear axle of a vehicle, None for one that may be stationary.

    The corners of a turning vehicle move across its heading, the rear axle does not.
    """
    if tracks.models[tracks.probability[t].argmax()] == "stationary":
        return None
    yaw_rate, variance = filtered.yaw_rate(tracks, t)
    lever = 1j * -from_axle(tracks, t)
    (xx, xy), (_, yy) = tracks.estimate_covariance[t, 2:4, 2:4].tolist()
    x, y = lever.real, lever.imag
    of_axle = xx + variance * x * x, xy + variance * x * y, yy + variance * y * y
    velocity = complex(*tracks.estimate[t, 2:4].tolist()) + yaw_rate * lever
    return orientation.course(velocity, of_axle)


def turn(tracks: TrackTable, t: int, quarters: int) -> None:
    """Describe the same box by a heading turned by `quarters`."""
    if quarters == 0:
        return
    heading.turn_heading(tracks, t, quarters)
    tracks.corner_sign[t] = orientation.turn_sign(tracks.corner_sign[t], quarters)
    if quarters % 2:
        tracks.corner_variance[t] = tracks.corner_variance[t, ::-1].copy()
        vehicle_size.swap_sides(tracks, t)


def absorb(
    tracks: TrackTable, t: int, low: Floats, high: Floats, selection: ModelSelection, config: TrackConfig
) -> None:
    """Extend a track to a box that contains it.

    `low` and `high` are the corners (2,) of that box relative to the centre of the seen part, along and across the
    heading [m].
    """
    sign = tracks.corner_sign[t]
    offset = rotate_one(np.where(sign > 0, high, low) - 0.5 * sign * tracks.visible_size[t], tracks.yaw.item(t, 0))
    yaw_rate, _ = heading_filter(config.filters).yaw_rate(tracks, t)
    corner.shift(tracks, t, offset, yaw_rate)
    selection.summarise(tracks, np.array([t]))
    tracks.contradicted_from[t] += offset
    vehicle_size.extend_size(tracks, t, high - low)

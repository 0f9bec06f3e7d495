"""Track confirmation: probability that a track is a vehicle, from the shape of its views and from its motion."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
from luxloop.tracker.bounds import require_within
from luxloop.tracker.tracking.orientation import correlated_sum
from luxloop.tracker.tracking.track_table import TrackTable
from luxloop.tracker.vehicle_classes import CLASSES, FACE_MIN_M, TRUNCATED_PROBABILITY, class_log_odds

LEFT_MARGIN_M = 1.5
"""Clearance of a vehicle that left a place [m]: the position of a small piece of wall along the wall is this
uncertain."""


VIEW_CORRELATION = 0.2
"""Correlation of the views of one object: the evidence of many equal views is that of five."""

VIEW_LOG_ODDS_MAX = 2.0
"""Maximum evidence of one view against a vehicle, log-odds."""

VEHICLE_LOG_ODDS_MAX = 3.0
"""Maximum evidence of one view for a vehicle, log-odds."""

FLAT_LOG_ODDS = 2.0
"""Evidence against a vehicle of a side that a vehicle would show, but is missing, log-odds."""

MOTION_LOG_ODDS = 20.0
"""Evidence of an object that left its first place, log-odds: background does not move."""

MOVED_VIEWS_MIN = 5
"""Minimum number of successive observations away from the first place that are motion: a wall between two vehicles that
pass it seems to move with them, and its truncated ends are found in most views, but not in all."""


CERTAIN = 1.0 - 1e-9
"""Largest probability of a vehicle, for finite log-odds."""


@dataclass(frozen=True, slots=True)
class ConfirmationConfig:
    """Track confirmation, coasting and termination."""

    vehicle_prior: float = 0.5
    """Probability that a new track is a vehicle: about half of the objects of vehicle size beside roads are.
    Decrease it among many walls and hedges."""
    confirm_probability: float = 0.9
    """Probability of a vehicle at which a track is confirmed; at the opposite one it becomes tentative again.
    Increase it if false tracks cost more than late ones."""
    confirm_hits: int = 3
    """Minimum number of observations for confirmation. Increase it with the rate of scans."""
    tentative_coast_s: float = 0.15
    """A tentative track is terminated if it was not seen for longer than this before the last scan [s].
    Increase it for slower scans: two of them at 12.5 Hz."""
    gap_s: float = 0.25
    """A confirmed track stays confirmed through gaps up to this length [s] and coasts after it. Increase it for slower
    scans: three of them at 12.5 Hz."""

    def __post_init__(self) -> None:
        require_within(self, 0.5, 1.0 - 1e-9, "confirm_probability")
        require_within(self, 1e-9, 1.0 - 1e-9, "vehicle_prior")


def log_odds(probability: float) -> float:
    """Return the log-odds of a probability."""
    return elementary.log(probability / (1.0 - probability))


def view_log_odds(size: Floats, untruncated: Bools, flat: bool) -> Floats:
    """(C,) evidence of a view of two sides (2,) [m], which may lack a side, for each vehicle class; limited."""
    shape = class_log_odds(size, untruncated, TRUNCATED_PROBABILITY) - FLAT_LOG_ODDS * flat
    return np.minimum(np.maximum(shape, -VIEW_LOG_ODDS_MAX), VEHICLE_LOG_ODDS_MAX)


def count_view(tracks: TrackTable, t: int, size: Floats, untruncated: Bools, flat: bool) -> None:
    """Count a view of a track as evidence for or against a vehicle."""
    tracks.shape_evidence[t] += view_log_odds(size, untruncated, flat)
    tracks.shape_views[t] += 1


def vehicle_odds(tracks: TrackTable, t: int) -> float:
    """Return the log-odds that a track is a vehicle of any class, each with its share of all vehicles."""
    views = tracks.shape_views.item(t)
    shape = 0.0
    for kind, evidence in zip(CLASSES, tracks.shape_evidence[t].tolist(), strict=True):
        shape += kind.share * elementary.exp(correlated_sum(evidence, views, VIEW_CORRELATION))
    return tracks.prior_log_odds.item(t) + elementary.log(shape) + tracks.left.item(t) * MOTION_LOG_ODDS


def reacquire(tracks: TrackTable, t: int, same: float, config: ConfirmationConfig) -> None:
    """Begin again with an object that is, with a probability `same`, the vehicle that was hidden.

    Another object is a vehicle with the prior probability of new tracks. Motion counts again as soon as the object
    moves, as the vehicle did.
    """
    vehicle = same / (1.0 + elementary.exp(-vehicle_odds(tracks, t))) + (1.0 - same) * config.vehicle_prior
    tracks.prior_log_odds[t] = log_odds(min(vehicle, CERTAIN))
    tracks.moved_before_hidden[t] |= tracks.left[t]
    tracks.left[t] = False
    tracks.moved_views[t] = tracks.moving_views[t] = tracks.shape_views[t] = 0
    tracks.shape_evidence[t] = 0.0
    tracks.birthplace[t] = tracks.first_ends[t] = np.nan


def footprint(tracks: TrackTable, t: int) -> tuple[float, float, float, float, float]:
    """Return x, y [m], heading, length and width [m] of the visible part of a vehicle."""
    (x, y), (front, left) = tracks.estimate[t, :2].tolist(), tracks.corner_sign[t].tolist()
    (length, width), heading = tracks.visible_size[t].tolist(), tracks.yaw.item(t, 0)
    middle = complex(x, y) - complex(0.5 * front * length, 0.5 * left * width) * elementary.rotation(heading)
    return middle.real, middle.imag, heading, length, width


def clear_of(one: tuple[float, ...], other: tuple[float, ...]) -> tuple[bool, bool]:
    """Return flags of the axes, along and across the heading of a footprint, on which it does not overlap another one.

    The speed of a filter does not show that an object moved: while more and more of a wall comes into view, its
    centre moves like that of a vehicle, but it always overlaps its first footprint.
    """
    (x, y, heading, length, width), (other_x, other_y, other_heading, other_length, other_width) = one, other
    away = complex(x - other_x, y - other_y) * elementary.rotation(-heading)
    turn = elementary.rotation(other_heading - heading)
    cos, sin = abs(turn.real), abs(turn.imag)
    along = 0.5 * (length + cos * other_length + sin * other_width)
    across = 0.5 * (width + sin * other_length + cos * other_width)
    return abs(away.real) > along + LEFT_MARGIN_M, abs(away.imag) > across + LEFT_MARGIN_M


def check_motion(
    tracks: TrackTable,
    t: int,
    size: Floats,
    untruncated: Bools,
    end_visible: Bools,
    corner_sign: Ints,
    moving: bool,
) -> None:
    """Check if an object leaves its first place, or is `moving` on as before it was hidden.

    The view has extents (2,) [m], masks (2,) of untruncated sides and of visible near ends, and near signs (2,). A
    single truncated face seems to slide along itself when its occluder moves, so only its motion across counts.
    """
    place = footprint(tracks, t)
    if math.isnan(tracks.birthplace.item(t, 0)):
        tracks.birthplace[t] = place
    length, width = size.tolist()
    faces = width > FACE_MIN_M, length > FACE_MIN_M
    clear = clear_of(place, tuple(tracks.birthplace[t].tolist()))
    sides = zip(untruncated.tolist(), faces, clear, strict=True)
    moves = any((whole or face) and away for whole, face, away in sides)
    moves |= end_moves(tracks, t, faces, end_visible, corner_sign)
    tracks.moved_views[t] = tracks.moved_views[t] + 1 if moves else 0
    tracks.moving_views[t] = tracks.moving_views[t] + 1 if moving else 0
    left = bool(tracks.moved_views[t] >= MOVED_VIEWS_MIN)
    left |= bool(tracks.moved_before_hidden[t] and tracks.moving_views[t] >= MOVED_VIEWS_MIN)
    tracks.left[t] |= left


def end_moves(tracks: TrackTable, t: int, faces: tuple[bool, bool], end_visible: Bools, corner_sign: Ints) -> bool:
    """Return True if a visible end is away from its first place; remember the place of an end that is new."""
    corner, back = complex(*tracks.estimate[t, :2].tolist()), elementary.rotation(-tracks.yaw.item(t, 0))
    moves = False
    for axis, (visible, face, sign) in enumerate(zip(end_visible.tolist(), faces, corner_sign.tolist(), strict=True)):
        if visible and face:
            end = t, axis, int(sign > 0)
            if math.isnan(tracks.first_ends[end].item(0)):
                tracks.first_ends[end] = corner.real, corner.imag
            shift = (corner - complex(*tracks.first_ends[end].tolist())) * back
            moves |= abs(shift.imag if axis else shift.real) > LEFT_MARGIN_M
    return moves

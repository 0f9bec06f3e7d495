"""Track confirmation: probability that a track is a vehicle, from the shape of its views and from its motion."""

from dataclasses import dataclass

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats
from luxloop.tracker.bounds import require_within
from luxloop.tracker.tracking.orientation import correlated_sum
from luxloop.tracker.tracking.track_table import TrackTable
from luxloop.tracker.vehicle_classes import CLASSES, TRUNCATED_PROBABILITY, class_log_odds

VIEW_CORRELATION = 0.2
"""Correlation of the views of one object: the evidence of many equal views is that of five."""

VIEW_LOG_ODDS_MAX = 2.0
"""Maximum evidence of one view against a vehicle, log-odds."""

VEHICLE_LOG_ODDS_MAX = 3.0
"""Maximum evidence of one view for a vehicle, log-odds."""

FLAT_LOG_ODDS = 2.0
"""Evidence against a vehicle of a side that a vehicle would show, but is missing, log-odds."""

MOTION_LOG_ODDS = 20.0
"""Evidence of an object that was seen to move, log-odds: background does not."""

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
    tracks.moved_views[t] = tracks.shape_views[t] = 0
    tracks.shape_evidence[t] = 0.0
    tracks.first_places[t] = np.nan


def footprint(tracks: TrackTable, t: int) -> tuple[float, float, float, float, float]:
    """Return x, y [m], heading, length and width [m] of the visible part of a vehicle."""
    (x, y), (front, left) = tracks.estimate[t, :2].tolist(), tracks.corner_sign[t].tolist()
    (length, width), heading = tracks.visible_size[t].tolist(), tracks.yaw.item(t, 0)
    middle = complex(x, y) - complex(0.5 * front * length, 0.5 * left * width) * elementary.rotation(heading)
    return middle.real, middle.imag, heading, length, width

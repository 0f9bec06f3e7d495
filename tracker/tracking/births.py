"""Second observation of a new track: any speed along an axis of the vehicle, if shape and heading agree.

A track starts without a velocity. The gate of its prior speed admits urban traffic. A faster vehicle is found by the
motion between two scans (two-point initiation, Bar-Shalom, Li, Kirubarajan 2001, section 5.5.3): rigid, along its
length, and within the speed of any vehicle.
"""

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools, Floats
from luxloop.tracker.geometry import rotate
from luxloop.tracker.tracking.hypotheses import Hypotheses, Predictions
from luxloop.tracker.tracking.observations import Observations
from luxloop.tracker.vehicle_classes import FASTEST_MPS

SIDEWAYS_FRACTION = 0.1
"""Maximum motion across the heading as a fraction of the motion along it: 6 degrees, three of a fit's errors."""

SIDEWAYS_M = 0.5
"""Maximum motion across the heading that errors of two fits explain [m]."""

TURN_SIGMA = 3.0
"""Maximum difference of the headings, in standard deviations."""

HEADING_STD_RAD = 0.05
"""Heading error of a fit beyond its covariance [rad]: rounded corners that are fitted as sides."""

SIZE_MAX_M = 1.5
"""Maximum difference of a side that both views show [m]: more of it comes into view between two scans."""

NEARBY_M = 1.0
"""Within this distance the gate decides, because errors of partial views exceed the motion [m]."""

SIDE_MIN_M = 1.0
"""Minimum visible extent of a side [m]; a shorter one may face away. Both views must show one side."""


def nearby(hypotheses: Hypotheses) -> Bools:
    """(T, B) mask of boxes that are at the place of the track."""
    return np.asarray(
        elementwise.hypot(hypotheses.innovation[:, :, 0, 0], hypotheses.innovation[:, :, 0, 1]) < NEARBY_M
    )


def second_views(
    tracks: Predictions,
    hypotheses: Hypotheses,
    observations: Observations,
    age_s: Floats,
    visible_size: Floats,
) -> Bools:
    """(T, B) mask of boxes that may be the second view of a vehicle.

    Parameters
    ----------
    age_s
        (T,) time since the first view [s].
    visible_size
        (T, 2) extent of the first view along and across the heading [m].
    """
    moved = np.abs(rotate(hypotheses.innovation[:, :, 0], -tracks.heading[:, None]))
    # The box of a new track has a quarter-turn ambiguity: either axis may be the length.
    along, across = np.maximum(moved[:, :, 0], moved[:, :, 1]), np.minimum(moved[:, :, 0], moved[:, :, 1])
    straight = across < SIDEWAYS_M + SIDEWAYS_FRACTION * along
    variance = tracks.heading_variance[:, None] + observations.covariance[:, 2, 2] + HEADING_STD_RAD**2
    turn = np.abs(hypotheses.heading - tracks.heading[:, None]) / np.sqrt(variance)
    both = np.minimum(hypotheses.size, visible_size[:, None]) > SIDE_MIN_M
    differs = both & (np.abs(hypotheses.size - visible_size[:, None]) > SIZE_MAX_M)
    same = both.any(axis=2) & ~differs.any(axis=2) & (turn < TURN_SIGMA)
    return np.asarray(same & straight & (along < age_s[:, None] * FASTEST_MPS))

"""Observation of one track: a box in the terms of that track."""

from dataclasses import dataclass

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.geometry import QUARTER, rotate_one, wrap
from luxloop.tracker.tracking.hypotheses import Hypotheses, shows_end
from luxloop.tracker.tracking.observations import Observations, uncut
from luxloop.tracker.tracking.orientation import turn_sign, turn_size


@dataclass(frozen=True, slots=True, eq=False)
class TrackObservation:
    """Observation of one track, odometry frame."""

    misfit: Floats
    """(M, 2) measured minus predicted position of the tracked corner, by each model [m]; M is 0 for the first one."""
    covariance: Floats
    """(2, 2) of the measured corner [m^2]."""
    heading: float
    """Measured heading, near that of the track [rad]."""
    heading_variance: float
    """[rad^2]."""
    size: Floats
    """(2,) seen extent along and across the heading [m]."""
    exact: Bools
    """(2,) mask of axes on which the near end of the box is the end of the vehicle."""
    whole: Bools
    """(2,) mask of axes on which the box is truncated at neither end."""
    flat: bool
    """True if the box lacks a side that a vehicle would show, or is a part of a larger object."""
    corner_sign: Ints
    """(2,) signs of the corner to track from now on."""
    time_offset: float = 0.0
    """Time of the box minus time of the scan [s]."""


def track_observation(hypotheses: Hypotheses, seen: Observations, t: int, b: int) -> TrackObservation:
    """Return box `b` as an observation of track `t`."""
    return TrackObservation(
        misfit=hypotheses.misfit[t, b],
        covariance=hypotheses.covariance[t, b] + hypotheses.ambiguity[t, b],
        heading=hypotheses.heading.item(t, b),
        heading_variance=seen.covariance.item(b, 2, 2),
        size=hypotheses.size[t, b],
        exact=hypotheses.exact[t, b],
        whole=hypotheses.whole[t, b],
        flat=seen.flat.item(b),
        corner_sign=hypotheses.corner_sign[t, b],
        time_offset=seen.time_offset.item(b),
    )


def first_observation(seen: Observations, b: int, turns: int, usual: Floats) -> tuple[TrackObservation, Floats]:
    """Return box `b` as the first observation of a track, and the corner (2,) to track [m].

    The heading of the vehicle is `turns` quarters from that of the box; `usual` (2,) is the prior size [m].
    """
    heading = wrap(float(seen.heading[b]) + turns * QUARTER)
    size, near = turn_size(seen.size[b], turns), turn_sign(seen.corner_sign[b], turns)
    cut = np.concatenate([seen.cut[b, turns:], seen.cut[b, :turns]])
    first = TrackObservation(
        misfit=np.zeros((0, 2)),
        covariance=seen.covariance[b, :2, :2],
        heading=heading,
        heading_variance=float(seen.covariance[b, 2, 2]),
        size=size,
        whole=uncut(cut),
        flat=bool(seen.flat[b]),
        exact=shows_end(size, near, cut, usual),
        corner_sign=near,
        time_offset=float(seen.time_offset[b]),
    )
    to_corner = rotate_one(0.5 * seen.corner_sign[b] * seen.size[b], seen.heading.item(b))
    return first, seen.center[b] + to_corner

"""Observations of tracks: boxes in the terms of the tracks that they were assigned to."""

from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.tracker.tracking.hypotheses import Hypotheses
from luxloop.tracker.tracking.observations import Observations


@dataclass(frozen=True, slots=True, eq=False)
class TrackObservations:
    """P observations of as many tracks, odometry frame."""

    row: Ints
    """(P,) track that each one updates, a row of the table."""
    innovation: Floats
    """(P, M, 2) measured minus predicted position of the tracked corner, by each model [m]."""
    covariance: Floats
    """(P, 2, 2) of the measured corner [m^2]."""
    heading: Floats
    """(P,) measured heading, near that of the track."""
    heading_variance: Floats
    """(P,) [rad^2]."""
    size: Floats
    """(P, 2) seen extent along and across the heading [m]."""
    end_visible: Bools
    """(P, 2) mask of axes on which the near end of the box is the end of the vehicle."""
    untruncated: Bools
    """(P, 2) mask of axes on which the box is truncated at neither end."""
    flat: Bools
    """(P,) mask of boxes that lack a side that a vehicle would show, or are a part of a larger object."""
    corner_sign: Ints
    """(P, 2) signs of the corner to track from now on."""
    time_offset: Floats
    """(P,) time of the box minus time of the scan [s]."""

    def __len__(self) -> int:
        return len(self.row)


def assigned(hypotheses: Hypotheses, observations: Observations, pairs: list[tuple[int, int]]) -> TrackObservations:
    """Return the boxes of pairs (track, box) as observations of their tracks."""
    row, b = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return TrackObservations(
        row=row,
        innovation=hypotheses.innovation[row, b],
        covariance=hypotheses.covariance[row, b] + hypotheses.ambiguity[row, b],
        heading=hypotheses.heading[row, b],
        heading_variance=observations.covariance[b, 2, 2],
        size=hypotheses.size[row, b],
        end_visible=hypotheses.end_visible[row, b],
        untruncated=hypotheses.untruncated[row, b],
        flat=observations.flat[b],
        corner_sign=hypotheses.corner_sign[row, b],
        time_offset=observations.time_offset[b],
    )

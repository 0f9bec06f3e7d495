"""One box, read as one track: what a track is told of itself in a frame."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import QUARTER, wrap
from tracker.records import MODELS
from tracker.tracking.hypotheses import Hypotheses, HypothesisConfig, named_after, shows_end
from tracker.tracking.observations import Observations, uncut
from tracker.tracking.orientation import turn_sign, turn_size


@dataclass(frozen=True, slots=True, eq=False)
class TrackObservation:
    """One box, read as one track."""

    misfit: Floats
    """(M, 2) from where each model predicts the tracked corner to where the box has it [m]."""
    covariance: Floats
    """(2, 2) of the latter [m^2], odometry frame."""
    heading: float
    """Near the track's own [rad]."""
    heading_variance: float
    """[rad^2]."""
    size: Floats
    """(2,) seen extent along and across the heading [m]."""
    exact: Bools
    """(2,) whether the near end along and across is where the vehicle ends."""
    whole: Bools
    """(2,) whether what is seen along and across is cut off at neither end."""
    flat: bool
    """Whether it misses a side that a vehicle would show, or is but a part of something larger."""
    corner_sign: Ints
    """(2,) the corner to track from now on."""


def track_observation(pairing: Hypotheses, seen: Observations, t: int, b: int) -> TrackObservation:
    """Box `b`, read as an observation of track `t`."""
    return TrackObservation(
        misfit=pairing.misfit[t, b],
        covariance=pairing.covariance[t, b] + pairing.silence[t, b],
        heading=float(pairing.heading[t, b]),
        heading_variance=float(seen.covariance[b, 2, 2]),
        size=pairing.size[t, b],
        exact=pairing.exact[t, b],
        whole=pairing.whole[t, b],
        flat=bool(seen.flat[b]),
        corner_sign=pairing.corner_sign[t, b],
    )


def first_observation(
    seen: Observations, b: int, turns: int, usual: Floats, config: HypothesisConfig
) -> tuple[TrackObservation, Floats]:
    """Box `b` as the first sighting of a track, and the corner (2,) to follow [m].

    The vehicle's heading is `turns` quarters from the box's, and it would `usual`ly be (2,) long and wide [m].
    """
    heading = wrap(float(seen.heading[b]) + turns * QUARTER)
    size, near = turn_size(seen.size[b], turns), turn_sign(seen.corner_sign[b], turns)
    cut = seen.cut[b][named_after(np.asarray(turns))]
    first = TrackObservation(
        misfit=np.zeros((len(MODELS), 2)),
        covariance=seen.covariance[b, :2, :2],
        heading=heading,
        heading_variance=float(seen.covariance[b, 2, 2]),
        size=size,
        whole=uncut(cut),
        flat=bool(seen.flat[b]),
        exact=shows_end(size, near.astype(np.float64), cut, usual, config),
        corner_sign=near,
    )
    return first, seen.corner[b]

"""Hypotheses: every box as an observation of every track, with the ends of the vehicle that it shows."""

from dataclasses import dataclass

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.bounds import require_within
from luxloop.tracker.geometry import rotate
from luxloop.tracker.tracking.kernels import hypotheses as kernel
from luxloop.tracker.tracking.observations import Observations, uncut


@dataclass(frozen=True, slots=True)
class HypothesisConfig:
    """Interpretation of a box as a view of a vehicle."""

    corner_margin_m: float = 0.5
    """Hysteresis of the tracked corner: another corner must be nearer to the ego by this much [m]."""
    face_min_m: float = 0.6
    """A face that is visible over this width shows the end of the vehicle on its side [m]."""
    whole_share: float = 0.85
    """A side is complete if this share of it is visible; rounded corners hide the rest."""
    end_std_m: float = 0.15
    """Standard deviation of an end whose face is not visible [m]: beam spacing, rounding, occlusion boundary."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1e3, "corner_margin_m", "face_min_m", "whole_share", "end_std_m")


@dataclass(frozen=True, slots=True, eq=False)
class Predictions:
    """Predicted states of T tracks by each of M models, in the odometry frame."""

    position: Floats
    """(T, M, 2) tracked corner at the scan's time [m]."""
    velocity: Floats
    """(T, M, 2) [m/s]."""
    covariance: Floats
    """(T, M, 2, 2) of the tracked corner."""
    probability: Floats
    """(T, M) model probabilities."""
    heading: Floats
    """(T,)."""
    heading_variance: Floats
    """(T,) [rad^2]."""
    size: Floats
    """(T, 2) length and width, unseen parts from priors [m]."""
    known_size: Floats
    """(T, 2) part of length and width that is known to exist, from the tracked corner on [m]."""
    whole: Bools
    """(T, 2) mask of length and width that were seen from end to end."""
    corner_sign: Ints
    """(T, 2) signs of the tracked corner."""

    @property
    def to_corner(self) -> Floats:
        """(T, 2) vector from the box centre to the tracked corner [m]."""
        return rotate(0.5 * self.corner_sign * self.size, self.heading)

    @property
    def selected(self) -> Floats:
        """(T, 2) tracked corner by the likeliest model [m]."""
        return np.asarray(self.position[np.arange(len(self.heading)), self.probability.argmax(axis=1)])


@dataclass(frozen=True, slots=True, eq=False)
class Hypotheses:
    """Every box as an observation of every track, (T, B) pairs, in the odometry frame."""

    heading: Floats
    """(T, B) heading of the box, turned by quarters to that of the track."""
    size: Floats
    """(T, B, 2) seen extent along and across that heading [m]."""
    whole: Bools
    """(T, B, 2) mask of axes, along and across that heading, on which the box is truncated at neither end."""
    misfit: Floats
    """(T, B, M, 2) measured minus predicted position of the tracked corner, by each model [m]."""
    covariance: Floats
    """(T, B, 2, 2) of the box's corner [m^2]."""
    ambiguity: Floats
    """(T, B, 2, 2) covariance to add where the box contains no information on the motion [m^2]."""
    corner_sign: Ints
    """(T, B, 2) signs of the corner to track from now on."""
    exact: Bools
    """(T, B, 2) mask of axes on which the near end of the box is the end of the vehicle."""
    reach: Floats | None = None
    """(T, B, M, 2) as `misfit`, for a vehicle that extends over the whole of its assumed size: for the gate [m]."""


def hypothesise(tracks: Predictions, seen: Observations, config: HypothesisConfig) -> Hypotheses:
    """Interpret each of B boxes as each of T tracks; the track's heading identifies length, width, front and rear.

    On `exact` axes the near end of the box is that of the vehicle. On other axes the box may be a piece of the side,
    truncated by an occluder or a gap between units: the misfit is only the part of the piece that protrudes from the
    known extent of the vehicle. Models are evaluated at the time of the box.

    The `reach` is the misfit under the smallest error of the size: the vehicle extends over the whole of its assumed
    size, and either end of a longer box may be that of the vehicle.

    The corner to track is the nearest one, with a hysteresis of `corner_margin_m`. Within the margin both corners are
    equally visible, and a change would cost accuracy. The track does not change to an end that is not visible now and
    was never visible, because the position of that end is unknown.
    """
    heading, size, near, cut = kernel.turned_views(tracks.heading, seen.heading, seen.size, seen.corner_sign, seen.cut)
    exact, corner_sign, misfit, reach, faceless, ambiguity = kernel.hypothesise(
        (tracks.position, tracks.velocity, tracks.probability.argmax(axis=1)),
        tracks.heading,
        (tracks.size, tracks.known_size, tracks.corner_sign),
        (seen.center, seen.time_offset, seen.sensor),
        (heading, size, near, cut),
        (config.corner_margin_m, config.face_min_m, config.whole_share, config.end_std_m),
    )
    return Hypotheses(
        heading=heading,
        size=size,
        whole=uncut(cut),
        misfit=misfit,
        covariance=seen.covariance[:, :2, :2] + faceless,
        ambiguity=ambiguity,
        corner_sign=corner_sign,
        exact=exact,
        reach=reach,
    )


def shows_end(size: Floats, near: Ints, cut: Bools, whole: Floats, config: HypothesisConfig) -> Bools:
    """(2,) mask of axes on which the near end of a box of size (2,) with cut ends (4,) is the end of the vehicle.

    Its near signs are (2,), and the assumed sides of the vehicle (2,) [m].
    """
    view = size, near, cut, whole
    return np.array([kernel.shows_end(*view, axis, config.face_min_m, config.whole_share) for axis in (0, 1)])

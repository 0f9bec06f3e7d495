"""Every box read as an observation of every track: which end of the vehicle it shows, and how far off that is."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.bounds import require_within
from tracker.geometry import QUARTER, rotate
from tracker.tracking.observations import Observations, uncut

SILENT_VARIANCE_M2 = 100.0
"""Of a measurement that neither corrects a filter nor tells one model from another."""


@dataclass(frozen=True, slots=True)
class HypothesisConfig:
    """What a box tells of a vehicle."""

    corner_margin_m: float = 0.5
    """Another corner must be nearer to the ego by this much before the track moves over to it [m]."""
    face_min_m: float = 0.6
    """A face seen this wide fixes where the vehicle ends on its side [m]."""
    whole_share: float = 0.85
    """A side of which this share is seen is seen as a whole; rounded corners hide the rest."""
    end_std_m: float = 0.15
    """Noise of an end whose face is not seen [m]: the beams' spacing, its rounding, the edge of what hides the rest."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1e3, "corner_margin_m", "face_min_m", "whole_share", "end_std_m")


@dataclass(frozen=True, slots=True, eq=False)
class Predictions:
    """What T tracks expect to see by each of M models, in the odometry frame."""

    position: Floats
    """(T, M, 2) tracked corner at the scan's time [m]."""
    velocity: Floats
    """(T, M, 2) [m/s]."""
    covariance: Floats
    """(T, M, 2, 2) of the tracked corner."""
    probability: Floats
    """(T, M) of each model."""
    heading: Floats
    """(T,)."""
    heading_variance: Floats
    """(T,) [rad^2]."""
    size: Floats
    """(T, 2) length, width, unseen sides from priors [m]."""
    known_size: Floats
    """(T, 2) how much of both is known to be there, from the tracked corner on [m]."""
    corner_sign: Ints
    """(T, 2) which corner is tracked."""

    @property
    def to_corner(self) -> Floats:
        """(T, 2) from the box centre to the tracked corner [m]."""
        return rotate(0.5 * self.corner_sign * self.size, self.heading)

    @property
    def selected(self) -> Floats:
        """(T, 2) tracked corner by the likeliest model [m]."""
        return np.asarray(self.position[np.arange(len(self.heading)), self.probability.argmax(axis=1)])


@dataclass(frozen=True, slots=True, eq=False)
class Hypotheses:
    """Every box read as an observation of every track, (T, B) pairs, in the odometry frame."""

    heading: Floats
    """(T, B) the box's heading, turned by quarters towards the track's."""
    size: Floats
    """(T, B, 2) seen extent along and across that heading [m]."""
    whole: Bools
    """(T, B, 2) whether the box is cut off at neither end along and across that heading."""
    misfit: Floats
    """(T, B, M, 2) from where a model predicts the tracked corner to where the box has it [m]."""
    covariance: Floats
    """(T, B, 2, 2) of the box's corner [m^2]."""
    silence: Floats
    """(T, B, 2, 2) to be added to it where the box says nothing of the motion [m^2]."""
    corner_sign: Ints
    """(T, B, 2) the corner to follow from now on."""
    exact: Bools
    """(T, B, 2) whether the near end along and across that heading is where the vehicle ends."""


def hypothesise(tracks: Predictions, seen: Observations, config: HypothesisConfig) -> Hypotheses:
    """Read each of B boxes as each of T tracks: the track's heading tells length from width, and front from rear."""
    turns = np.round((tracks.heading[:, None] - seen.heading) / QUARTER)
    heading = seen.heading + turns * QUARTER
    size = np.where((turns % 2 == 1)[..., None], seen.size[:, ::-1], seen.size)
    near = np.round(rotate(np.broadcast_to(seen.corner_sign, size.shape), -turns * QUARTER))
    cut = np.take_along_axis(np.broadcast_to(seen.cut, (*turns.shape, 4)), named_after(turns), axis=2)
    exact = shows_end(size, near, cut, tracks.size[:, None], config)
    misfit = fit_in(tracks, seen, heading, size, near, exact)
    axes = rotate(np.eye(2), tracks.heading[:, None])
    # A piece may lie anywhere on its side: where that contradicts no model, it says nothing of any.
    silent = ~exact & np.all(misfit == 0, axis=2)
    faceless = size[..., ::-1] < config.face_min_m
    end_variance = np.where(faceless, config.end_std_m**2, 0.0)
    return Hypotheses(
        heading=heading,
        size=size,
        whole=uncut(cut),
        misfit=rotate(misfit, tracks.heading[:, None, None]),
        covariance=seen.covariance[:, :2, :2] + np.einsum("tki,tbk,tkj->tbij", axes, end_variance, axes),
        silence=np.einsum("tki,tbk,tkj->tbij", axes, np.where(silent, SILENT_VARIANCE_M2, 0.0), axes),
        corner_sign=follow(tracks, seen, near, exact, config),
        exact=exact,
    )


def named_after(turns: Floats) -> Ints:
    """(..., 4) the ends that are front, left, rear and right once the heading has been turned by quarters (...)."""
    return np.asarray((np.arange(4) + turns[..., None].astype(np.int64)) % 4)


def at_end(flags: Bools, sign: Floats) -> Bools:
    """(..., 2) of flags (..., 4) of front, left, rear and right those on the sides of a sign (..., 2)."""
    return np.where(sign > 0, flags[..., :2], flags[..., 2:])


def shows_end(size: Floats, near: Floats, cut: Bools, whole: Floats, config: HypothesisConfig) -> Bools:
    """(..., 2) whether the near end of a box along and across the heading is where the vehicle ends.

    So it is if the face there is seen. Without it, if nothing cuts the box off there, and the side is seen about as
    long as a `whole` (..., 2) one, or is cut off at its other end, which explains that it is not.
    """
    long = size >= config.whole_share * whole
    return (size[..., ::-1] >= config.face_min_m) | (~at_end(cut, near) & (long | at_end(cut, -near)))


def fit_in(
    tracks: Predictions, seen: Observations, heading: Floats, size: Floats, near: Floats, exact: Bools
) -> Floats:
    """How far each model must move to agree with each box, (T, B, M, 2) along and across the heading [m].

    Where the near end of an axis is the vehicle's, it is `exact` (T, B, 2). Where it is not, what is seen may be a
    piece of the side, cut off by an occluder or a gap between units: a model moves only as far as the piece sticks out
    of what is known to be there.
    A box is held against where a model has the vehicle when the box was seen.
    """
    center = tracks.position - tracks.to_corner[:, None]
    moved = tracks.velocity[:, None] * seen.time_offset[:, None, None]
    offset = rotate(seen.center[:, None] - center[:, None] - moved, -tracks.heading[:, None, None])
    turn = heading - tracks.heading[:, None]
    near_end = offset + 0.5 * (rotate(near * size, turn) - near * tracks.size[:, None])[:, :, None]
    known_center = 0.5 * tracks.corner_sign * (tracks.size - tracks.known_size)
    shift, excess = offset - known_center[:, None, None], 0.5 * (size - tracks.known_size[:, None])[:, :, None]
    sticks_out = np.maximum(shift + excess, 0) + np.minimum(shift - excess, 0)
    return np.where(exact[:, :, None], near_end, sticks_out)


def follow(tracks: Predictions, seen: Observations, near: Floats, exact: Bools, config: HypothesisConfig) -> Ints:
    """(T, B, 2) the corner to follow: the nearest, but the tracked one until another is nearer by a margin.

    In between both are seen equally well, and a change would only cost accuracy. Nor does the track go to the
    other end of a side that is neither seen now nor has been: nobody knows where that end is.
    """
    tracked = np.broadcast_to(tracks.corner_sign[:, None], near.shape)
    center = tracks.selected - tracks.to_corner

    def range_m(sign: Floats | Ints) -> Floats:
        corner = center[:, None] + rotate(0.5 * sign * tracks.size[:, None], tracks.heading[:, None])
        return np.asarray(np.linalg.norm(corner - seen.sensor, axis=-1))

    keeps = range_m(tracked) <= range_m(near) + config.corner_margin_m
    known = tracks.known_size >= tracks.size - config.corner_margin_m
    moves = ~keeps[..., None] & (exact | known[:, None])
    return np.where(moves, near, tracked).astype(np.int64)

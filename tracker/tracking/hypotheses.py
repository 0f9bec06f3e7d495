"""Hypotheses: every box as an observation of every track, with the ends of the vehicle that it shows."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools, Floats, Ints
from tracker.bounds import require_within
from tracker.geometry import QUARTER, rotate
from tracker.tracking.observations import Observations, uncut

CAR_LENGTH_SPREAD_M = 1.5
"""Difference of the lengths of cars at most [m], but for few: the corner's error covers it."""

AMBIGUOUS_VARIANCE_M2 = 100.0
"""Variance of a measurement that neither corrects a filter nor separates models [m^2]."""


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
    """Interpret each of B boxes as each of T tracks; the track's heading identifies length, width, front and rear."""
    turns = np.round((tracks.heading[:, None] - seen.heading) / QUARTER)
    heading = seen.heading + turns * QUARTER
    size = np.where((turns % 2 == 1)[..., None], seen.size[:, ::-1], seen.size)
    near = np.round(rotate(np.broadcast_to(seen.corner_sign, size.shape), -turns * QUARTER))
    cut = np.take_along_axis(np.broadcast_to(seen.cut, (*turns.shape, 4)), turned_ends(turns), axis=2)
    exact = shows_end(size, near, cut, tracks.size[:, None], config)
    exact &= ~contradicts_size(tracks, seen, size, near, config)
    misfit, reach = misfits(tracks, seen, heading, size, near, exact)
    axes = rotate(np.eye(2), tracks.heading[:, None])
    # The position of a piece along its side is ambiguous: where it contradicts no model, it must not favour one.
    ambiguous = ~exact & np.all(misfit == 0, axis=2)
    faceless = size[..., ::-1] < config.face_min_m
    end_variance = np.where(faceless, config.end_std_m**2, 0.0)
    return Hypotheses(
        heading=heading,
        size=size,
        whole=uncut(cut),
        misfit=rotate(misfit, tracks.heading[:, None, None]),
        covariance=seen.covariance[:, :2, :2] + np.einsum("tki,tbk,tkj->tbij", axes, end_variance, axes),
        ambiguity=np.einsum("tki,tbk,tkj->tbij", axes, np.where(ambiguous, AMBIGUOUS_VARIANCE_M2, 0.0), axes),
        corner_sign=next_corner(tracks, seen, near, exact, config),
        exact=exact,
        reach=rotate(reach, tracks.heading[:, None, None]),
    )


def turned_ends(turns: Floats) -> Ints:
    """(..., 4) indices of the ends that are front, left, rear and right after the heading turns by quarters (...)."""
    return np.asarray((np.arange(4) + turns[..., None].astype(np.int64)) % 4)


def at_end(flags: Bools, sign: Floats) -> Bools:
    """(..., 2) flags of the ends on the side of a sign (..., 2), from flags (..., 4) of front, left, rear and right."""
    return np.where(sign > 0, flags[..., :2], flags[..., 2:])


def shows_end(size: Floats, near: Floats, cut: Bools, whole: Floats, config: HypothesisConfig) -> Bools:
    """(..., 2) mask of axes on which the near end of a box is the end of the vehicle.

    It is if the face there is visible. Without a face, it is if the box is not truncated there, and its side is either
    about as long as the `whole` (..., 2) side [m], or truncated at the other end, which explains the difference.
    """
    long = size >= config.whole_share * whole
    return (size[..., ::-1] >= config.face_min_m) | (~at_end(cut, near) & (long | at_end(cut, -near)))


def contradicts_size(
    tracks: Predictions, seen: Observations, size: Floats, near: Floats, config: HypothesisConfig
) -> Bools:
    """(T, B, 2) mask of axes on which a box contradicts an uncertain size: its far end is at the tracked end.

    The near end of such a box corrects the size of the vehicle. It is no end that moved.
    """
    center = tracks.selected - tracks.to_corner
    offset = rotate(seen.center - center[:, None], -tracks.heading[:, None])
    tracked, growth = tracks.corner_sign[:, None], 0.5 * (size - tracks.size[:, None])
    near_end, tracked_end = np.abs(offset + near * growth), np.abs(offset + tracked * growth)
    uncertain = tracks.known_size < tracks.size - config.corner_margin_m
    differs = (near_end > CAR_LENGTH_SPREAD_M) & (tracked_end < near_end)
    return np.asarray(uncertain[:, None] & (near != tracked) & differs)


def misfits(
    tracks: Predictions, seen: Observations, heading: Floats, size: Floats, near: Floats, exact: Bools
) -> tuple[Floats, Floats]:
    """Corrections (T, B, M, 2) that make each model agree with each box, along and across the heading [m].

    On `exact` (T, B, 2) axes the near end of the box is that of the vehicle. On other axes the box may be a piece of
    the side, truncated by an occluder or a gap between units: the correction is only the part of the piece that
    protrudes from the known extent of the vehicle. Models are evaluated at the time of the box.

    The second array is the `reach`, under the smallest error of the size: the vehicle extends over the whole of its
    assumed size, and either end of a longer box may be that of the vehicle.
    """
    center = tracks.position - tracks.to_corner[:, None]
    moved = tracks.velocity[:, None] * seen.time_offset[:, None, None]
    offset = rotate(seen.center[:, None] - center[:, None] - moved, -tracks.heading[:, None, None])
    turn = heading - tracks.heading[:, None]
    near_end = offset + 0.5 * (rotate(near * size, turn) - near * tracks.size[:, None])[:, :, None]
    far_end = near_end - (near * np.maximum(size - tracks.size[:, None], 0.0))[:, :, None]
    either = np.where(np.abs(far_end) < np.abs(near_end), far_end, near_end)
    shown, ends = exact[:, :, None], (near_end, either)
    within = (protrusion(offset, size, tracks, extent) for extent in (tracks.known_size, tracks.size))
    misfit, reach = (np.where(shown, end, piece) for end, piece in zip(ends, within, strict=True))
    return misfit, reach


def protrusion(offset: Floats, size: Floats, tracks: Predictions, extent: Floats) -> Floats:
    """(T, B, M, 2) part of boxes (T, B, 2) that protrudes from an extent (T, 2) of the vehicle, from its corner on [m].

    `offset` (T, B, M, 2) is the position of the box relative to the vehicle.
    """
    middle = 0.5 * tracks.corner_sign * (tracks.size - extent)
    shift, excess = offset - middle[:, None, None], 0.5 * (size - extent[:, None])[:, :, None]
    return np.maximum(shift + excess, 0) + np.minimum(shift - excess, 0)


def next_corner(tracks: Predictions, seen: Observations, near: Floats, exact: Bools, config: HypothesisConfig) -> Ints:
    """(T, B, 2) signs of the corner to track: the nearest one, with a hysteresis of `corner_margin_m`.

    Within the margin both corners are equally visible, and a change would cost accuracy. The track does not change to
    an end that is not visible now and was never visible, because the position of that end is unknown.
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

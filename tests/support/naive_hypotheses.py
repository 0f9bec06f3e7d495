"""Reference implementations of the kernels of hypotheses and of their scores: the same equations in plain numpy."""

import numpy as np

from luxloop.tracker.geometry import QUARTER, mahalanobis, rotate
from luxloop.tracker.tracking.association import GATE_PROBABILITY_MIN, GROWTH_STD_M, HEADING_STD_RAD
from luxloop.tracker.tracking.hypotheses import (
    AMBIGUOUS_VARIANCE_M2,
    CAR_LENGTH_SPREAD_M,
    COMPLETE_FRACTION,
    Hypotheses,
)
from luxloop.tracker.tracking.observations import uncut
from luxloop.tracker.vehicle_classes import FACE_MIN_M


def hypothesise(tracks, seen, config):
    """Interpret each of B boxes as each of T tracks; the track's heading identifies length, width, front and rear."""
    turns = np.round((tracks.heading[:, None] - seen.heading) / QUARTER)
    heading = seen.heading + turns * QUARTER
    size = np.where((turns % 2 == 1)[..., None], seen.size[:, ::-1], seen.size)
    near = np.round(rotate(np.broadcast_to(seen.corner_sign, size.shape), -turns * QUARTER))
    cut = np.take_along_axis(np.broadcast_to(seen.cut, (*turns.shape, 4)), turned_ends(turns), axis=2)
    end_visible = shows_end(size, near, cut, tracks.size[:, None])
    end_visible &= ~contradicts_size(tracks, seen, size, near, config)
    innovation, innovation_lenient = innovations(tracks, seen, heading, size, near, end_visible)
    axes = rotate(np.eye(2), tracks.heading[:, None])
    ambiguous = ~end_visible & np.all(innovation == 0, axis=2)
    faceless = size[..., ::-1] < FACE_MIN_M
    end_variance = np.where(faceless, config.end_std_m**2, 0.0)
    return Hypotheses(
        heading=heading,
        size=size,
        untruncated=uncut(cut),
        innovation=rotate(innovation, tracks.heading[:, None, None]),
        covariance=seen.covariance[:, :2, :2] + np.einsum("tki,tbk,tkj->tbij", axes, end_variance, axes),
        ambiguity=np.einsum("tki,tbk,tkj->tbij", axes, np.where(ambiguous, AMBIGUOUS_VARIANCE_M2, 0.0), axes),
        corner_sign=next_corner(tracks, seen, near, end_visible, config),
        end_visible=end_visible,
        innovation_lenient=rotate(innovation_lenient, tracks.heading[:, None, None]),
    )


def turned_ends(turns):
    """(..., 4) indices of the ends that are front, left, rear and right after the heading turns by quarters (...)."""
    return (np.arange(4) + turns[..., None].astype(np.int64)) % 4


def at_end(flags, sign):
    """(..., 2) flags of the ends on the side of a sign (..., 2), from flags (..., 4) of front, left, rear and right."""
    return np.where(sign > 0, flags[..., :2], flags[..., 2:])


def shows_end(size, near, cut, whole):
    """(..., 2) mask of axes on which the near end of a box is the end of the vehicle."""
    long = size >= COMPLETE_FRACTION * whole
    return (size[..., ::-1] >= FACE_MIN_M) | ~at_end(cut, near) & (long | at_end(cut, -near))


def contradicts_size(tracks, seen, size, near, config):
    """(T, B, 2) mask of axes on which a box contradicts an uncertain size: its far end is at the tracked end."""
    center = tracks.selected - tracks.to_corner
    offset = rotate(seen.center - center[:, None], -tracks.heading[:, None])
    tracked, growth = tracks.corner_sign[:, None], 0.5 * (size - tracks.size[:, None])
    near_end, tracked_end = np.abs(offset + near * growth), np.abs(offset + tracked * growth)
    uncertain = tracks.known_size < tracks.size - config.corner_margin_m
    differs = (near_end > CAR_LENGTH_SPREAD_M) & (tracked_end < near_end)
    return uncertain[:, None] & (near != tracked) & differs


def innovations(tracks, seen, heading, size, near, end_visible):
    """Corrections (T, B, M, 2) that make each model agree with each box, along and across the heading [m]."""
    center = tracks.position - tracks.to_corner[:, None]
    moved = tracks.velocity[:, None] * seen.time_offset[:, None, None]
    offset = rotate(seen.center[:, None] - center[:, None] - moved, -tracks.heading[:, None, None])
    turn = heading - tracks.heading[:, None]
    near_end = offset + 0.5 * (rotate(near * size, turn) - near * tracks.size[:, None])[:, :, None]
    far_end = near_end - (near * np.maximum(size - tracks.size[:, None], 0.0))[:, :, None]
    either = np.where(np.abs(far_end) < np.abs(near_end), far_end, near_end)
    shown, ends = end_visible[:, :, None], (near_end, either)
    within = (protrusion(offset, size, tracks, extent) for extent in (tracks.known_size, tracks.size))
    return (np.where(shown, end, piece) for end, piece in zip(ends, within, strict=True))


def protrusion(offset, size, tracks, extent):
    """(T, B, M, 2) part of boxes (T, B, 2) that protrudes from an extent (T, 2) of the vehicle, from its corner on."""
    middle = 0.5 * tracks.corner_sign * (tracks.size - extent)
    shift, excess = offset - middle[:, None, None], 0.5 * (size - extent[:, None])[:, :, None]
    return np.maximum(shift + excess, 0) + np.minimum(shift - excess, 0)


def next_corner(tracks, seen, near, end_visible, config):
    """(T, B, 2) signs of the corner to track: the nearest one, with a hysteresis of `corner_margin_m`."""
    tracked = np.broadcast_to(tracks.corner_sign[:, None], near.shape)
    center = tracks.selected - tracks.to_corner

    def range_m(sign):
        corner = center[:, None] + rotate(0.5 * sign * tracks.size[:, None], tracks.heading[:, None])
        return np.linalg.norm(corner - seen.sensor, axis=-1)

    keeps = range_m(tracked) <= range_m(near) + config.corner_margin_m
    known = tracks.known_size >= tracks.size - config.corner_margin_m
    moves = ~keeps[..., None] & (end_visible | known[:, None])
    return np.where(moves, near, tracked).astype(np.int64)


def shape_difference(tracks, hypotheses, heading_variance):
    """Squared normalised differences (T, B) of heading, and (T, B, 2) of length and width of boxes that are larger."""
    turn = hypotheses.heading - tracks.heading[:, None]
    variance = tracks.heading_variance[:, None] + heading_variance + HEADING_STD_RAD**2
    excess = np.maximum(hypotheses.size - tracks.size[:, None], 0.0) / GROWTH_STD_M
    return turn**2 / variance, excess**2


def score(tracks, hypotheses, seen, config, coasting=None):
    """Return the cost (T, B) of each pair, and a mask (T, B) of boxes inside the gate (5) of any probable model."""
    view = config.view_std_m**2 * np.eye(2)
    spread = tracks.covariance[:, None] + hypotheses.covariance[:, :, None] + view
    squared, determinant = mahalanobis(hypotheses.innovation, spread)
    log_likelihood = np.log(tracks.probability)[:, None] - 0.5 * (squared + np.log(determinant))
    turn, excess = shape_difference(tracks, hypotheses, seen.covariance[:, 2, 2])
    shape = np.minimum(turn, config.shape_cost_max) + np.minimum(excess.sum(axis=2), config.shape_cost_max)
    cost = shape - 2 * np.logaddexp.reduce(log_likelihood, axis=2)
    likely = tracks.probability[:, None] >= GATE_PROBABILITY_MIN
    if not config.shape_cost_max:
        return cost, np.any(likely & (squared < config.gate_chi2), axis=2)
    if hypotheses.innovation_lenient is not None:
        squared = np.minimum(squared, mahalanobis(hypotheses.innovation_lenient, spread)[0])
    too_large = np.sum(excess * tracks.whole[:, None], axis=2) >= config.gate_chi2
    rotated = False if coasting is None else coasting[:, None] & (turn >= config.gate_chi2)
    return cost, np.any(likely & (squared < config.gate_chi2), axis=2) & ~too_large & ~np.asarray(rotated)

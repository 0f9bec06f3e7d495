"""Sizes of the tracked vehicles: what was seen of their sides, and posterior probabilities of length and width.

Bayes' rule over a grid of sizes. Length and width of one class are independent; the class connects them, so that a wide
front belongs to a long vehicle.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.vehicle_classes import (
    CAR_LONGEST_M,
    FACE_MIN_M,
    GRID_M,
    TRUNCATED_PROBABILITY,
    side_probabilities,
)

if TYPE_CHECKING:
    from luxloop.tracker.tracking.track_table import TrackTable

VIEW_CORRELATION = 0.2
"""Correlation of the views of a side: many equal views have the evidence of five."""

FORGETTING = 0.04
"""Share of the earlier evidence that a view of the whole side replaces: two seconds at 12.5 scans a second."""

MERGED_PROBABILITY = 0.05
"""Probability that a view contains more than the vehicle: a neighbour, or a doubled contour."""

GROWTH = 0.5
"""Initial gain of the size filter for a side that is longer than remembered."""

SETTLED_GROWTH = 0.05
"""Final gain, after many views of the whole side: the gain decreases with each, so that a box merged with its
neighbour has little effect. A whole side that looks shorter has half the gain, because ends have few points."""

GROWN_MIN_M = 0.5
"""A side that grows by more than this was truncated before [m]: two beams at either end."""

KNOWN_FRACTION = 0.8
"""A side is known to exist completely if this fraction of it was seen."""

HIDDEN_LENGTH_M = 0.27
"""Part of a length that rounded corners hide from a view of the whole side [m]: 0.2 to 0.4 on cars."""

HIDDEN_WIDTH_M = 0.15
"""Part of a width that they hide [m]: 0.1 to 0.2 on cars."""

HIDDEN_M: Floats = np.array([HIDDEN_LENGTH_M, HIDDEN_WIDTH_M])
"""(2,) both."""


def known(seen: Floats, size: Floats) -> Floats:
    """Part of each side (..., 2) that is known to exist [m]: the whole `size` once nearly all was seen."""
    return np.where(seen >= KNOWN_FRACTION * size, size, seen)


def likely(seen: Floats, size: Floats, std: Floats) -> Floats:
    """Part of each side (..., 2) that probably exists [m], with the standard deviations of `size`."""
    return np.asarray(np.maximum(np.minimum(seen, size), size - std))


def first_view(size: Floats, untruncated: Bools) -> tuple[Floats, Floats, Ints, Floats, Floats]:
    """Return the columns of a new track: likelihoods, those of pieces, numbers of views, size and its deviation.

    Its first view has extents (2,) [m] and a mask (2,) of untruncated sides.
    """
    likelihood, of_pieces = np.zeros((2, 2, len(GRID_M)))
    views = np.zeros((2, 2), dtype=np.int64)
    estimated = add_view_and_estimate(likelihood, of_pieces, views, size, untruncated, HIDDEN_M, side_probabilities())
    return likelihood, of_pieces, views, *estimated


def observe_size(tracks: "TrackTable", t: int, observed: Floats, untruncated: Bools) -> None:
    """Update the size of a track by extents (2,) [m], with a mask (2,) of untruncated sides."""
    gains, growth = (GROWTH, SETTLED_GROWTH), (GROWN_MIN_M, CAR_LONGEST_M)
    memory = tracks.visible_size[t], tracks.whole_views[t]
    tracks.visible_size[t] = remembered_extents(*memory, observed, untruncated, gains, growth)
    posterior = tracks.size_likelihood[t], tracks.piece_likelihood[t], tracks.size_views[t]
    estimated = add_view_and_estimate(*posterior, observed, untruncated, HIDDEN_M, side_probabilities())
    tracks.size[t], tracks.size_std[t] = estimated


def extend_size(tracks: "TrackTable", t: int, seen: Floats) -> None:
    """Set the seen extents (2,) [m] of a track to those of several pieces together, and exclude shorter sides."""
    tracks.visible_size[t] = seen
    weight, cut = np.full(2, LOG_ODDS_MAX), np.zeros(2, np.bool_)
    add_view(tracks.size_likelihood[t], seen, cut, weight, np.zeros(2), HIDDEN_M)
    posterior = tracks.size_likelihood[t], tracks.piece_likelihood[t]
    tracks.size[t], tracks.size_std[t] = estimate(*posterior, side_probabilities())


def swap_sides(tracks: "TrackTable", t: int) -> None:
    """Rename the sides of a track for a heading turned by a quarter."""
    for column in (tracks.visible_size, tracks.whole_views, tracks.size_likelihood, tracks.piece_likelihood):
        column[t] = column[t, ::-1].copy()
    tracks.size_views[t] = tracks.size_views[t, :, ::-1].copy()
    posterior = tracks.size_likelihood[t], tracks.piece_likelihood[t]
    tracks.size[t], tracks.size_std[t] = estimate(*posterior, side_probabilities())


@kernel()
def remember(seen: float, observed: float, whole: bool, whole_views: int, gains: tuple[float, float]) -> float:
    """Return the remembered extent of a side after one more observation [m].

    A vehicle is at least as large as its visible part. A side that is not seen from end to end may be longer, so a
    short observation of it has no effect. The gain falls from the first to the last of `gains` with the earlier
    observations of the whole side.
    """
    gain = max(gains[0] / (1 + whole_views), gains[1])
    if observed <= seen:
        gain = 0.5 * gain if whole and observed > FACE_MIN_M else 0.0
    return seen + gain * (observed - seen)


@kernel()
def remembered_extents(
    seen: Floats,
    whole_views: Ints,
    observed: Floats,
    whole: Bools,
    gains: tuple[float, float],
    growth_m: tuple[float, float],
) -> Floats:
    """Return the remembered extents (2,) after one more observation, and count views (2,) of the whole sides, in place.

    A side that grows by more than the first of `growth_m`, but not beyond the second one, the length of a car, was not
    whole before: earlier views do not slow its growth down.
    """
    remembered = np.empty(2)
    for axis in range(2):
        grown = seen[axis] + growth_m[0] < observed[axis] < growth_m[1]
        views = 0 if grown else whole_views[axis]
        remembered[axis] = remember(seen[axis], observed[axis], whole[axis], views, gains)
        whole_views[axis] += whole[axis] and observed[axis] > FACE_MIN_M
    return remembered


HIDDEN_STD_M = 0.12
"""Standard deviation of the part of a side that rounded corners hide [m]: bodies differ, and ends have few points."""

SIZE_STD_FRACTION = 0.02
"""Standard deviation of an extent that grows with the side, as a fraction of it: errors of heading and beam spacing."""

STD_M: Floats = elementwise.hypot(HIDDEN_STD_M, SIZE_STD_FRACTION * GRID_M)
"""(G,) standard deviation of the extent of each side of `GRID_M` [m]."""

NEGLIGIBLE_SIGMA = 12.0
"""Difference in standard deviations beyond which a normal density is below the rounding errors of the others."""

MARGIN_M = 0.1
"""Errors of range and heading by which a piece may exceed its side [m]."""

WHOLE_FRACTION = 0.3
"""Share of the sides that count as truncated, but are visible from end to end."""

LOG_ODDS_MAX = 15.0
"""Maximum log-odds of one size against another, so that later views can correct it."""


@kernel()
def whole_density(extent: float, g: int, hidden: float) -> float:
    """Density [1/m] of the visible extent [m] of a whole side `GRID_M[g]`, of which a part is `hidden` [m]."""
    off = (extent - (GRID_M[g] - hidden)) / STD_M[g]
    if abs(off) > NEGLIGIBLE_SIGMA:
        return 0.0
    return float(elementary.exp(-0.5 * off * off) / (STD_M[g] * math.sqrt(2.0 * math.pi)))


@kernel()
def add_view(
    log_likelihood: Floats,
    observed: Floats,
    whole: Bools,
    weight: Floats,
    forgetting: Floats,
    hidden: Floats,
) -> None:
    """Add a view of extents (2,) [m] to log-likelihoods (2, G), in place.

    A whole side shows its length but for what its corners hide, or a piece of it if it is truncated by something that
    was not detected. A truncated side is a lower bound. A merged view has any extent.
    """
    for axis in range(2):
        if weight[axis] == 0.0:
            continue
        highest, of_merged = -np.inf, elementary.log(MERGED_PROBABILITY)
        for g in range(len(GRID_M)):
            fits = observed[axis] < GRID_M[g] + MARGIN_M
            if whole[axis]:
                seen = whole_density(observed[axis], g, hidden[axis])
                piece = TRUNCATED_PROBABILITY / GRID_M[g] if fits else 0.0
                log_density = elementary.log(
                    (1.0 - TRUNCATED_PROBABILITY) * seen + piece + MERGED_PROBABILITY / GRID_M[-1]
                )
            else:
                log_density = 0.0 if fits else of_merged
            value = (1.0 - forgetting[axis]) * log_likelihood[axis, g] + weight[axis] * log_density
            log_likelihood[axis, g] = value
            highest = max(highest, value)
        for g in range(len(GRID_M)):
            log_likelihood[axis, g] = max(log_likelihood[axis, g] - highest, -LOG_ODDS_MAX)


@kernel()
def average_pieces(mean: Floats, observed: Floats, gain: Floats, hidden: Floats) -> None:
    """Average a truncated view of extents (2,) [m] into mean log-likelihoods (2, G), in place.

    The side shows a piece of any length, or all of it: an occluder or a gap between units that ends beside it counts as
    truncation, too. The views of a scene that stands still are one view, so they are averaged, with gains (2,).
    """
    for axis in range(2):
        if gain[axis] == 0.0:
            continue
        for g in range(len(GRID_M)):
            piece = (1.0 - WHOLE_FRACTION) / GRID_M[g] if observed[axis] < GRID_M[g] + MARGIN_M else 0.0
            seen = whole_density(observed[axis], g, hidden[axis])
            log_density = elementary.log(piece + WHOLE_FRACTION * seen + MERGED_PROBABILITY / GRID_M[-1])
            mean[axis, g] += gain[axis] * (log_density - mean[axis, g])


@kernel()
def add_view_and_estimate(
    log_likelihood: Floats,
    of_pieces: Floats,
    views: Ints,
    observed: Floats,
    whole: Bools,
    hidden: Floats,
    classes: tuple[Floats, Floats],
) -> tuple[Floats, Floats]:
    """Add a view of extents (2,) [m], `whole` (2,) if truncated at neither end; return the estimate, see `estimate`.

    Updates the log-likelihoods (2, G) of independent views and of pieces, and the numbers (2, 2) of all views and of
    pieces by side.
    """
    weight, forgets, gain = np.zeros(2), np.zeros(2), np.zeros(2)
    for axis in range(2):
        if observed[axis] <= FACE_MIN_M:
            continue
        views[0, axis] += 1
        weight[axis] = max(1.0 / views[0, axis], VIEW_CORRELATION)
        if whole[axis]:
            forgets[axis] = FORGETTING
        else:
            views[1, axis] = min(views[1, axis] + 1, round(1.0 / FORGETTING))
            gain[axis] = 1.0 / views[1, axis]
    add_view(log_likelihood, observed, whole, weight, forgets, hidden)
    average_pieces(of_pieces, observed, gain, hidden)
    return estimate(log_likelihood, of_pieces, classes)


@kernel()
def estimate(log_likelihood: Floats, of_pieces: Floats, classes: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Return the sides (2,) of the greatest expected overlap, and standard deviations (2,) about them [m].

    The log-likelihoods (2, G) are those of independent views and of pieces; `classes` are `side_probabilities`.
    """
    likelihood = np.empty_like(log_likelihood)
    for axis in range(2):
        for g in range(len(GRID_M)):
            likelihood[axis, g] = elementary.exp(log_likelihood[axis, g] + of_pieces[axis, g])
    probability = posterior(likelihood, *classes)
    size, std = np.empty(2), np.empty(2)
    for axis in range(2):
        size[axis] = side_of_greatest_overlap(probability[axis])
        variance = 0.0
        for g in range(len(GRID_M)):
            variance += probability[axis, g] * (GRID_M[g] - size[axis]) ** 2
        std[axis] = math.sqrt(variance)
    return size, std


@kernel()
def posterior(likelihood: Floats, share: Floats, prior: Floats) -> Floats:
    """(2, G) probabilities of the sides of `GRID_M`, from their likelihoods (2, G).

    Classes have shares (C,) and prior probabilities (C, 2, G).
    """
    evidence = np.zeros((len(share), 2))
    for kind in range(len(share)):
        for g in range(likelihood.shape[1]):  # both axes in one loop: two independent sums
            evidence[kind, 0] += prior[kind, 0, g] * likelihood[0, g]
            evidence[kind, 1] += prior[kind, 1, g] * likelihood[1, g]
    total = 0.0
    for kind in range(len(share)):
        total += share[kind] * evidence[kind, 0] * evidence[kind, 1]
    result = np.zeros_like(likelihood)
    for axis in range(2):
        for kind in range(len(share)):
            weight = share[kind] * evidence[kind, 1 - axis]
            for g in range(likelihood.shape[1]):
                result[axis, g] += weight * (prior[kind, axis, g] * likelihood[axis, g])
        for g in range(likelihood.shape[1]):
            result[axis, g] /= total
    return result


@kernel()
def side_of_greatest_overlap(probability: Floats) -> float:
    """Side a [m] with the greatest expected overlap min(a, b) / max(a, b) with the true one b, from a common end.

    In a narrow posterior, the mean of its neighbourhood refines the grid.
    """
    shorter, longer = 0.0, 0.0
    for g in range(len(GRID_M)):
        longer += probability[g] / GRID_M[g]
    best, place = -1.0, 0
    for g in range(len(GRID_M)):
        shorter += probability[g] * GRID_M[g]
        longer -= probability[g] / GRID_M[g]
        overlap = shorter / GRID_M[g] + longer * GRID_M[g]
        if overlap > best:
            best, place = overlap, g
    near, moment = 0.0, 0.0
    for g in range(max(place - 4, 0), min(place + 5, len(GRID_M))):
        near += probability[g]
        moment += probability[g] * GRID_M[g]
    return GRID_M[place] if near < 0.5 else moment / near

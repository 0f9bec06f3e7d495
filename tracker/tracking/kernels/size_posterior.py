"""Posterior probabilities of the sides of a vehicle, and the sides that they imply."""

import math

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.tracking.kernels.size_likelihood import add_view, average_pieces
from luxloop.tracker.tracking.vehicle_sizes import GRID_M, side_probabilities

SHARE, PRIOR = side_probabilities()


@kernel()
def observe(
    log_likelihood: Floats,
    of_pieces: Floats,
    views: Ints,
    observed: Floats,
    whole: Bools,
    visible_min_m: float,
    hidden: Floats,
    settings: tuple[float, float, float, float],
) -> tuple[Floats, Floats]:
    """Add a view of extents (2,) [m], `whole` (2,) if truncated at neither end; return the estimate, see `estimate`.

    Updates the log-likelihoods (2, G) of independent views and of pieces, and the numbers (2, 2) of all views and of
    pieces by side. The `settings` are the minimum weight of a view, the forgetting, and the probabilities of truncated
    and merged views; see `luxloop.tracker.tracking.size_posterior`.
    """
    weight_min, forgetting, truncated, merged = settings
    weight, forgets, gain = np.zeros(2), np.zeros(2), np.zeros(2)
    for axis in range(2):
        if observed[axis] <= visible_min_m:
            continue
        views[0, axis] += 1
        weight[axis] = max(1.0 / views[0, axis], weight_min)
        if whole[axis]:
            forgets[axis] = forgetting
        else:
            views[1, axis] = min(views[1, axis] + 1, round(1.0 / forgetting))
            gain[axis] = 1.0 / views[1, axis]
    add_view(log_likelihood, observed, whole, weight, forgets, hidden, truncated, merged)
    average_pieces(of_pieces, observed, gain, hidden, merged)
    return estimate(log_likelihood, of_pieces)


@kernel()
def estimate(log_likelihood: Floats, of_pieces: Floats) -> tuple[Floats, Floats]:
    """Return the sides (2,) of the greatest expected overlap, and standard deviations (2,) about them [m].

    The log-likelihoods (2, G) are those of independent views and of pieces.
    """
    likelihood = np.empty_like(log_likelihood)
    for axis in range(2):
        for g in range(len(GRID_M)):
            likelihood[axis, g] = math.exp(log_likelihood[axis, g] + of_pieces[axis, g])
    probability = posterior(likelihood, SHARE, PRIOR)
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

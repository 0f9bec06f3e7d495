"""Reference implementations of the kernels of sides and sizes: the same equations in plain Python and numpy."""

import math

import numpy as np

from luxloop.tracker.vehicle_classes import (
    BACKGROUND_LENGTH_M,
    CAR_LENGTH_MAX_M,
    CLASSES,
    FACE_MIN_M,
    GRID_M,
    OUTLIER_DENSITY,
    PAIR,
    PIECE_LOG_ODDS_MAX,
    ROUNDING_M,
    of_background,
    of_car,
    of_lorry,
)


def length_log_odds(size, whole, visible_min_m, truncated_probability):
    """Return the log-odds that the first of two sides is the length of a vehicle, and the second one its width."""
    sides = with_truncation(size, whole, truncated_probability)

    def density(sides):
        return sum(
            vehicle.share
            * side_density(sides[0], vehicle.length_m, visible_min_m)
            * side_density(sides[1], vehicle.width_m, visible_min_m)
            for vehicle in CLASSES
        )

    return math.log(density(sides) / density(sides[::-1]))


def class_log_odds(size, whole, truncated_probability):
    """Return the log-odds of a view of two sides (2,) [m] for each class, against a piece of a building or a wall."""
    sides = sorted(with_truncation(size, whole, truncated_probability), reverse=True)
    longer, shorter = sides[0][0], sides[1][0]

    def density(kind):
        face = (of_lorry if kind.flat else of_car)(shorter)
        both = 1.0 - kind.end_fraction - kind.side_fraction
        names = (kind.side_fraction, kind.length_m, kind.width_m), (kind.end_fraction, kind.width_m, kind.length_m)
        return sum(
            side_density(sides[0], one, 0.0) * (alone * face + both * side_density(sides[1], other, 0.0))
            for alone, one, other in names
        )

    low, high = BACKGROUND_LENGTH_M
    background = of_background(shorter) / (math.log(high / low) * max(longer, low))
    if longer > CAR_LENGTH_MAX_M:
        background += PAIR.share * density(PAIR)
    odds = [math.log(density(kind) / background) for kind in CLASSES]
    shown = sides if shorter >= FACE_MIN_M else sides[:1]
    piece = all(truncated == 1.0 for _, truncated in shown)
    limits = [PIECE_LOG_ODDS_MAX if kind.flat and piece else math.inf for kind in CLASSES]
    return [min(pair) for pair in zip(odds, limits, strict=True)]


def with_truncation(size, whole, truncated_probability):
    """Return visible extents [m] and probabilities of truncation of two sides."""
    pairs = zip(size.tolist(), whole.tolist(), strict=True)
    return [(extent, truncated_probability if seen else 1.0) for extent, seen in pairs]


def side_density(side, limits, visible_min_m):
    """Return the density of a side from a range of lengths [m], or 1 for one that may face away."""
    extent, truncated = side
    return piece_density(extent, truncated, *limits) + OUTLIER_DENSITY if extent > visible_min_m else 1.0


def piece_density(extent, truncated, low, high):
    """Return the density [1/m] of a visible extent [m] of a side from a range of lengths [m]."""
    whole = max(min(high, extent + ROUNDING_M) - max(low, extent), 0.0) / ROUNDING_M
    piece = math.log(high / max(low, extent)) if extent < high else 0.0
    return ((1.0 - truncated) * whole + truncated * piece) / (high - low)


def estimate(log_likelihood, share, prior):
    """Return the sides (2,) of the greatest expected overlap, and standard deviations (2,) about them [m]."""
    probability = posterior(log_likelihood, share, prior)
    size, std = np.empty(2), np.empty(2)
    for axis in range(2):
        size[axis] = side_of_greatest_overlap(probability[axis])
        std[axis] = math.sqrt(np.sum(probability[axis] * (GRID_M - size[axis]) ** 2))
    return size, std


def posterior(log_likelihood, share, prior):
    """(2, G) probabilities of the sides of `GRID_M`, from shares (C,) and probabilities (C, 2, G) of the classes."""
    joint = prior * np.exp(log_likelihood)
    result, total = np.zeros_like(log_likelihood), 0.0
    for kind in range(len(share)):
        length, width = joint[kind, 0].sum(), joint[kind, 1].sum()
        result[0] += share[kind] * width * joint[kind, 0]
        result[1] += share[kind] * length * joint[kind, 1]
        total += share[kind] * length * width
    return result / total


def side_of_greatest_overlap(probability):
    """Side a [m] with the greatest expected overlap min(a, b) / max(a, b) with the true one b, from a common end."""
    shorter, longer = 0.0, np.sum(probability / GRID_M)
    best, place = -1.0, 0
    for g in range(len(GRID_M)):
        shorter += probability[g] * GRID_M[g]
        longer -= probability[g] / GRID_M[g]
        overlap = shorter / GRID_M[g] + longer * GRID_M[g]
        if overlap > best:
            best, place = overlap, g
    near = probability[max(place - 4, 0) : place + 5]
    if near.sum() < 0.5:
        return float(GRID_M[place])
    return float(np.sum(near * GRID_M[max(place - 4, 0) : place + 5]) / near.sum())

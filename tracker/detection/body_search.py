"""Search for the bodies of segments: fits from the best candidate headings, and the choice among their results."""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.detection.kernels.bearings import even_subset
from luxloop.tracker.detection.kernels.body_starts import COST, STATE, directions, first_hypotheses
from luxloop.tracker.detection.kernels.bowed_faces import BodyShape
from luxloop.tracker.detection.kernels.groups import by_group, means
from luxloop.tracker.detection.kernels.heading_search import misalignments
from luxloop.tracker.detection.kernels.shape_search import best_bodies, fit_bodies

SAMPLE_MAX = 48
"""Points of the first fits; the last ones use all points."""
FIRST_ROUNDS = 4
"""Rounds of the first fits, at 4, 2, 1 and 1 times the noise."""
FIRST_SCALE = 4.0
LAST_FITS = 3
"""Maximum number of hypotheses that are fitted to all points."""
PLAUSIBLE = 15.0
"""Maximum difference of their costs in the first fit from the least one."""
LAST_ROUNDS = 2


def search_bodies(
    points: Floats, line: Ints, segment: Ints, offset: Ints, heading: Floats, shape: BodyShape, alignment: Floats,
    temperature: float,
) -> tuple[Floats, Floats, Floats]:  # fmt: skip
    """Find the body of each of S segments.

    Parameters
    ----------
    points
        (N, 2) grouped by segment, ego frame [m].
    line, segment
        (N,) scan line of each point, 0 and up; (N,) its segment.
    offset
        (S + 1,) first point of each segment, and N.
    heading
        (S, M) candidates [rad].
    alignment
        (3,) reach and flatness of `misalignment` [m], and its weight beside the cost of a body.
    temperature
        Difference of cost at which another result is e times less likely.

    Returns
    -------
    tuple
        Heading (S,) [rad], its cost per point (S,), and the covariance (S, 3, 3) of x, y and heading [m, rad].
    """
    found, owner = plausible_fits(points, line, segment, offset, heading, shape, alignment)
    order = by_line(line, segment)
    points, line, size = points.take(order, axis=0), line.take(order), np.diff(offset)
    center = means(points, segment, len(heading))
    triangle = fit_bodies(points, line, offset, center, found, owner, LAST_ROUNDS, 1.0, shape)
    aligned = misalignments(points, offset, found[:, STATE].copy(), owner, directions(center), alignment)
    found[:, COST] += alignment[2] * size[owner] * aligned
    best, covariance, turn = best_bodies(found, first_of_each(owner, len(heading)), triangle, temperature)
    return found[best, STATE], found[best, COST] / size, turn @ covariance @ turn.transpose(0, 2, 1)


def plausible_fits(
    points: Floats, line: Ints, segment: Ints, offset: Ints, heading: Floats, shape: BodyShape, alignment: Floats
) -> tuple[Floats, Ints]:
    """Fit bodies to subsets of segments from the best aligned headings; return the cheapest ones, and their segments.

    Faces are flat at first, behind a small share of the points.
    """
    center = means(points, segment, len(heading))
    chosen, first = even_subset(points, offset, SAMPLE_MAX)
    chosen = chosen[by_line(line[chosen], segment[chosen])]
    sample, candidates = points.take(chosen, axis=0), np.repeat(np.arange(len(heading)), heading.shape[1])
    aligned = misalignments(sample, first, heading.ravel(), candidates, directions(center), alignment)
    order = np.argsort(aligned.reshape(heading.shape), axis=1, kind="stable")
    found, owner = first_hypotheses(sample, first, center, heading, order)
    fit_bodies(sample, line[chosen], first, center, found, owner, FIRST_ROUNDS, FIRST_SCALE, shape)
    cheap = np.lexsort((found[:, COST], owner))
    cheap = cheap[plausible(found[cheap, COST], first_of_each(owner, len(heading)), owner)]
    return found[cheap], owner[cheap]


def by_line(line: Ints, segment: Ints) -> Ints:
    """(N,) indices of points by segment, and by scan line within one; lines and segments (N,) are 0 and up."""
    lines = int(line.max(initial=0)) + 1
    order: Ints = by_group(segment * lines + line, (int(segment.max(initial=-1)) + 1) * lines)[0]
    return order


def plausible(cost: Floats, first: Ints, owner: Ints) -> Bools:
    """(H,) mask of the cheapest hypotheses of each segment, ordered by segment `owner` (H,) and cost (H,)."""
    leader = first[owner]
    near: Bools = cost < cost[leader] + PLAUSIBLE
    return near & (np.arange(len(cost)) - leader < LAST_FITS)


def first_of_each(owner: Ints, count: int) -> Ints:
    """(count + 1,) first hypothesis of each segment in the ascending `owner` (H,), and H."""
    return np.searchsorted(owner, np.arange(count + 1))

"""Kernels of the search for a body: fits from the candidate headings, and the choice among their results."""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.body_equations import fit_body
from tracker.detection.kernels.body_starts import (
    STARTS_MAX,
    directions,
    distinct_starts,
    line_starts,
    quarter_difference,
    shallow_depth,
    visible_sides,
)
from tracker.detection.kernels.bowed_faces import STATES, BodyShape
from tracker.detection.kernels.cholesky import solve
from tracker.detection.kernels.heading_search import misalignment
from tracker.detection.kernels.segments import even_subset

HYPOTHESES_MAX = 8 * STARTS_MAX
"""Two places of the flank for each of up to four corners of a body beside the ego."""
SHALLOW_SHARE = 0.08
"""Share of the points in front of a face at its start: mirrors and range outliers."""
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


@njit(cache=True)
def first_fits(
    points: Floats, center: Floats, start: Ints, heading: float, shape: BodyShape, found: Floats, count: int
) -> int:
    """Fit bodies near a heading, for each pair of visible sides and place of the flank; return the new count.

    Faces are flat at first, behind a small share of the points. Rows of `found` (H, 5 + STATES) are cost, variance of
    the heading [rad^2], sides, flank, and state.
    """
    cos, sin, ray, side = math.cos(heading), math.sin(heading), directions(points), np.empty(2)
    centred, information, rank = points - center, np.empty((STATES, STATES)), int(SHALLOW_SHARE * len(points))
    along, across = cos * centred[:, 0] + sin * centred[:, 1], cos * centred[:, 1] - sin * centred[:, 0]
    for side[0] in visible_sides(cos * points[:, 1] - sin * points[:, 0]):
        for side[1] in visible_sides(cos * points[:, 0] + sin * points[:, 1]):
            shallow = shallow_depth(side[0] * across, rank), shallow_depth(side[1] * along, rank)
            for flank in range(2):
                state = np.zeros(STATES)
                state[0], state[1], state[4] = heading, shallow[0], shallow[1]
                found[count, 0] = fit_body(
                    centred, ray, start, state, side, flank, FIRST_ROUNDS, FIRST_SCALE, shape, information
                )
                found[count, 1] = heading_variance(information)
                found[count, 2:4], found[count, 4], found[count, 5:] = side, flank, state
                count += 1
    return count


@njit(cache=True)
def heading_variance(triangle: Floats) -> float:
    """Return the variance of the heading [rad^2] from the Cholesky factor of the information matrix."""
    unit = np.zeros(STATES)
    unit[0] = 1.0
    solve(triangle, unit)
    return float(unit[0])


@njit(cache=True)
def mixture_variance(found: Floats, best: int, temperature: float) -> float:
    """Return the variance of the heading about that of hypothesis `best`, over all, weighted by their likelihoods."""
    total, variance = 0.0, 0.0
    for i in range(len(found)):
        weight = math.exp(-min((found[i, 0] - found[best, 0]) / temperature, 700.0))
        turn = quarter_difference(found[i, 5], found[best, 5])
        total, variance = total + weight, variance + weight * (found[i, 1] + turn * turn)
    return variance / total


@njit(cache=True)
def ego_covariance(triangle: Floats, heading: float, side: Floats, heading_variance: float) -> Floats:
    """(3, 3) covariance of x, y and heading of a body that turns about the mean of its points, ego frame [m, rad].

    `triangle` is the Cholesky factor of the information matrix. Face 1 gives the position along the heading, face 0
    across it. `heading_variance` replaces that of the fit.
    """
    cos, sin, states = math.cos(heading), math.sin(heading), np.array([4, 1, 0])
    covariance, unit = np.empty((3, 3)), np.empty(STATES)
    for b in range(3):
        unit[:] = 0.0
        unit[states[b]] = 1.0
        solve(triangle, unit)
        covariance[:, b] = unit[states]
    stretch = math.sqrt(heading_variance / covariance[2, 2])
    turn = np.array([[cos * side[1], -sin * side[0], 0.0], [sin * side[1], cos * side[0], 0.0], [0.0, 0.0, stretch]])
    return np.asarray(turn @ covariance @ turn.T)


@njit(cache=True)
def plausible_fits(points: Floats, line: Ints, heading: Floats, shape: BodyShape, alignment: Floats) -> Floats:
    """Fit bodies to a subset of a segment from the best aligned headings (M,); return the rows of the cheapest ones."""
    center = np.array([points[:, 0].mean(), points[:, 1].mean()])
    toward = center / max(math.hypot(center[0], center[1]), 1e-6)
    chosen = even_subset(points, SAMPLE_MAX)
    chosen = chosen[np.argsort(line[chosen], kind="mergesort")]
    sample, start = points[chosen], line_starts(line[chosen])
    along, across, aligned = np.empty(len(chosen)), np.empty(len(chosen)), np.empty(len(heading))
    for m in range(len(heading)):
        aligned[m] = misalignment(sample, heading[m], toward, alignment[0], alignment[1], along, across)
    found, count = np.empty((HYPOTHESES_MAX, 5 + STATES)), 0
    for m in distinct_starts(heading, aligned):
        count = first_fits(sample, center, start, heading[m], shape, found, count)
    found = found[:count][np.argsort(found[:count, 0], kind="mergesort")]
    return found[: min(LAST_FITS, np.searchsorted(found[:, 0], found[0, 0] + PLAUSIBLE))]


@njit(cache=True)
def best_body(
    points: Floats, line: Ints, heading: Floats, shape: BodyShape, alignment: Floats, temperature: float
) -> tuple[float, float, Floats]:
    """Return heading [rad], cost per point, and covariance (3, 3) of the body of one segment; see `search_bodies`."""
    found, best = plausible_fits(points, line, heading, shape, alignment), 0
    order = np.argsort(line, kind="mergesort")
    points, start = points[order], line_starts(line[order])
    center = np.array([points[:, 0].mean(), points[:, 1].mean()])
    toward = center / max(math.hypot(center[0], center[1]), 1e-6)
    centred, ray, along, across = points - center, directions(points), np.empty(len(points)), np.empty(len(points))
    triangles = np.empty((len(found), STATES, STATES))
    for i in range(len(found)):
        state, side, flank = found[i, 5:], found[i, 2:4], int(found[i, 4])
        found[i, 0] = fit_body(centred, ray, start, state, side, flank, LAST_ROUNDS, 1.0, shape, triangles[i])
        aligned = misalignment(points, state[0], toward, alignment[0], alignment[1], along, across)
        found[i, 0] += alignment[2] * len(points) * aligned
        found[i, 1] = heading_variance(triangles[i])
        best = i if found[i, 0] < found[best, 0] else best
    variance = mixture_variance(found, best, temperature)
    covariance = ego_covariance(triangles[best], found[best, 5], found[best, 2:4], variance)
    return found[best, 5], found[best, 0] / len(points), covariance


@njit(cache=True)
def search_bodies(
    points: Floats, line: Ints, offset: Ints, heading: Floats, shape: BodyShape, alignment: Floats, temperature: float
) -> tuple[Floats, Floats, Floats]:
    """Find the body of each of S segments.

    Parameters
    ----------
    points
        (N, 2) grouped by segment, ego frame [m].
    line
        (N,) scan line of each point, 0 and up.
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
        Heading (S,) [rad], its cost per point (S,), and the covariance (S, 3, 3) of `ego_covariance`.
    """
    segments = len(heading)
    best_heading, cost, covariance = np.empty(segments), np.empty(segments), np.empty((segments, 3, 3))
    for s in range(segments):
        own = slice(offset[s], offset[s + 1])
        best_heading[s], cost[s], covariance[s] = best_body(
            points[own], line[own], heading[s], shape, alignment, temperature
        )
    return best_heading, cost, covariance

"""Kernels of the search for bodies: fits of hypotheses, and the choice among their results."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.body_equations import fit_body
from luxloop.tracker.detection.kernels.body_starts import (
    COST,
    FLANK,
    HEADING_VARIANCE,
    SIDE,
    STATE,
    directions,
    line_starts,
    quarter_difference,
)
from luxloop.tracker.detection.kernels.bowed_faces import STATES, Beams, BodyShape
from luxloop.tracker.detection.kernels.cholesky import solve
from luxloop.tracker.detection.kernels.groups import columns


@kernel(error_model="numpy")
def fit_bodies(
    points: Floats,
    line: Ints,
    offset: Ints,
    center: Floats,
    found: Floats,
    owner: Ints,
    rounds: int,
    scale: float,
    shape: BodyShape,
) -> Floats:
    """Fit hypotheses (H, STATE + STATES) in place to the points of their segments; see `fit_body`.

    Return the Cholesky factors (H, STATES, STATES) of their information matrices.

    Parameters
    ----------
    points, line
        (N, 2) grouped by segment, and by scan line within one [m]; (N,) scan lines.
    offset, center
        (S + 1,) first point of each segment, and N; (S, 2) origin of the states of its hypotheses [m].
    owner
        (H,) segment of each hypothesis.
    """
    triangle, (ray_x, ray_y) = np.empty((len(found), STATES, STATES)), columns(directions(points))
    x, y = columns(points)
    for s in range(len(center)):
        for i in range(offset[s], offset[s + 1]):
            x[i], y[i] = x[i] - center[s, 0], y[i] - center[s, 1]
    start = np.empty(0, np.int64)
    for h in range(len(found)):
        first, end = offset[owner[h]], offset[owner[h] + 1]
        start = line_starts(line[first:end]) if h == 0 or owner[h] != owner[h - 1] else start
        beams = Beams(x[first:end], y[first:end], ray_x[first:end], ray_y[first:end])
        found[h, COST] = fit_body(
            beams, start, found[h, STATE:], found[h, SIDE : SIDE + 2],
            int(found[h, FLANK]), rounds, scale, shape, triangle[h],
        )  # fmt: skip
    return triangle


@kernel(error_model="numpy")
def mixture_variance(found: Floats, best: int, temperature: float) -> float:
    """Return the variance of the heading about that of hypothesis `best`, over all, weighted by their likelihoods."""
    total, variance = 0.0, 0.0
    for i in range(len(found)):
        weight = math.exp(-min((found[i, COST] - found[best, COST]) / temperature, 700.0))
        turn = quarter_difference(found[i, STATE], found[best, STATE])
        total, variance = total + weight, variance + weight * (found[i, HEADING_VARIANCE] + turn * turn)
    return variance / total


@kernel(error_model="numpy")
def best_bodies(found: Floats, first: Ints, triangle: Floats, temperature: float) -> tuple[Ints, Floats, Floats]:
    """Return the best hypothesis of each segment (S,), and two factors (S, 3, 3) of the covariance of its body.

    The first is the covariance C of the depth of face 1, that of face 0, and the heading; the second the matrix T to x,
    y and heading of a body that turns about the mean of its points, ego frame [m, rad]: T C T^T. Face 1 gives the
    position along the heading, face 0 across it. The variance of the heading becomes that of all hypotheses.

    Parameters
    ----------
    found, triangle
        (H, STATE + STATES), (H, STATES, STATES) hypotheses by segment, and Cholesky factors of `fit_bodies`.
    first
        (S + 1,) first hypothesis of each segment, and H.
    temperature
        Difference of cost at which another result is e times less likely.
    """
    best, solved = np.empty(len(first) - 1, np.int64), np.empty((3, STATES))
    covariance, turn = np.empty((len(best), 3, 3)), np.zeros((len(best), 3, 3))
    for h in range(len(found)):
        found[h, HEADING_VARIANCE] = unit_solution(triangle[h], 0, solved[0])
    for s in range(len(best)):
        best[s] = first[s]
        for h in range(first[s], first[s + 1]):
            best[s] = h if found[h, COST] < found[best[s], COST] else best[s]
        variance = mixture_variance(found[first[s] : first[s + 1]], best[s] - first[s], temperature)
        heading, side_0, side_1 = found[best[s], STATE], found[best[s], SIDE], found[best[s], SIDE + 1]
        for b, state in enumerate((4, 1, 0)):
            unit_solution(triangle[best[s]], state, solved[b])
            covariance[s, 0, b], covariance[s, 1, b], covariance[s, 2, b] = solved[b, 4], solved[b, 1], solved[b, 0]
        turn[s, 0, 0], turn[s, 0, 1] = math.cos(heading) * side_1, -math.sin(heading) * side_0
        turn[s, 1, 0], turn[s, 1, 1] = math.sin(heading) * side_1, math.cos(heading) * side_0
        turn[s, 2, 2] = math.sqrt(variance / covariance[s, 2, 2])
    return best, covariance, turn


@kernel(error_model="numpy")
def unit_solution(triangle: Floats, state: int, solved: Floats) -> float:
    """Write a column of the inverse of the information matrix, (STATES,); return its diagonal element, the variance."""
    for a in range(STATES):
        solved[a] = 1.0 if a == state else 0.0
    solve(triangle, solved)
    return float(solved[state])

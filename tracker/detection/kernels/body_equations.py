"""Kernels that fit a heading and two bowed faces to the points of a body, by iteratively reweighted least squares.

The offset of each scan line on each face is eliminated from the normal equations (Woodbury's identity).
"""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.bowed_faces import STATES, BodyShape, cost, face_priors, odds_inside, residuals
from tracker.detection.kernels.cholesky import factor, solve

TURN_MAX = math.radians(6.0)
"""Maximum turn in one iteration [rad]; the equations are linear in small angles."""
DEPTH_STD = 10.0
"""Standard deviation of the depth of a face without points [m]: it is unknown."""
HEADING_STD = 0.5 * math.pi / math.sqrt(12.0)
"""Standard deviation of a heading without points, uniform over a quarter turn [rad]."""


@njit(cache=True)
def normal_equations(
    start: Ints,
    state: Floats,
    side: Floats,
    prior: Floats,
    scale: float,
    shape: BodyShape,
    found: Floats,
    information: Floats,
    gradient: Floats,
) -> None:
    """Write information matrix (7, 7), lower triangle, and gradient (7,) of the state, with priors, without offsets."""
    information[:], gradient[:] = 0.0, 0.0
    row, block, pull, sums = np.empty(4), np.zeros((2, 4, 4)), np.zeros((2, 4)), np.zeros((2, 6))
    for g in range(len(start) - 1):
        for i in range(start[g], start[g + 1]):
            depth, variance = found[0, i], scale * scale * found[1, i]
            if depth < 0.0 and 0.5 * depth * depth > shape.cost_max * variance:
                continue
            weight = 1.0 / (variance * (1.0 + odds_inside(depth, variance, shape)))
            k = 0 if found[4, i] == 0.0 else 1
            offset = found[2, i] - state[3 + 3 * k]
            slope = 2.0 * state[2 + 3 * k] * offset
            lever = -found[3, i] if k == 0 else found[3, i]
            row[0] = slope * lever - side[0] * found[2, i] if k == 0 else slope * lever + side[1] * found[2, i]
            row[1], row[2], row[3] = -1.0, -offset * offset, slope
            for a in range(4):
                scaled = weight * row[a]
                pull[k, a] -= scaled * depth
                sums[k, a] += scaled
                for b in range(a + 1):
                    block[k, a, b] += scaled * row[b]
            sums[k, 4] += weight
            sums[k, 5] += weight * depth
        for k in range(2):
            if sums[k, 4] > 0.0:
                share = 1.0 / (1.0 / shape.line_std**2 + sums[k, 4])
                for a in range(4):
                    pull[k, a] += share * sums[k, a] * sums[k, 5]
                    for b in range(a + 1):
                        block[k, a, b] -= share * sums[k, a] * sums[k, b]
                sums[k] = 0.0
    information[0, 0], gradient[0] = block[0, 0, 0] + block[1, 0, 0] + HEADING_STD**-2.0, pull[0, 0] + pull[1, 0]
    for k in range(2):
        for a in range(1, 4):
            at = a + 3 * k
            gradient[at], information[at, 0] = pull[k, a], block[k, a, 0]
            for b in range(1, a + 1):
                information[at, b + 3 * k] = block[k, a, b]
        information[1 + 3 * k, 1 + 3 * k] += DEPTH_STD**-2.0
        for a in range(2):
            at, certainty = 2 + a + 3 * k, prior[k, 2 * a + 1] ** -2.0
            information[at, at] += certainty
            gradient[at] += (prior[k, 2 * a] - state[at]) * certainty


@njit(cache=True)
def fit_body(
    points: Floats,
    ray: Floats,
    start: Ints,
    state: Floats,
    side: Floats,
    flank: int,
    rounds: int,
    scale: float,
    shape: BodyShape,
    information: Floats,
) -> float:
    """Improve a state (7,); return its cost, and write the Cholesky factor of its information matrix (7, 7).

    Parameters
    ----------
    flank
        Face that is a flank; the other is a front or rear.
    scale
        Factor of the noise in the first round, halved from round to round down to 1: a narrow start finds local
        minima. Above 1, curvature and middle of the faces start at their priors.
    """
    found, prior, step = np.empty((5, len(points))), np.empty((2, 5)), np.empty(STATES)
    for turn in range(rounds):
        residuals(points, ray, state, side, shape, found)
        face_priors(found, state, side, flank, shape, prior)
        if turn == 0 and scale > 1.0:
            for k in range(2):
                state[2 + 3 * k], state[3 + 3 * k] = prior[k, 0], prior[k, 2]
        noise_scale = max(1.0, scale * 0.5**turn)
        normal_equations(start, state, side, prior, noise_scale, shape, found, information, step)
        factor(information)
        solve(information, step)
        shortened = min(1.0, TURN_MAX / max(abs(step[0]), 1e-12))
        for a in range(STATES):
            state[a] += step[a] * shortened
    residuals(points, ray, state, side, shape, found)
    face_priors(found, state, side, flank, shape, prior)
    return cost(start, state, prior, flank, shape, found)

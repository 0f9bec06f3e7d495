"""Kernels that fit a heading and two bowed faces to the points of a body, by iteratively reweighted least squares.

The offset of each scan line on each face is eliminated from the normal equations (Woodbury's identity).
"""

import math

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.compiled import kernel
from tracker.detection.kernels.bowed_faces import (
    ASIDE,
    DEPTH,
    FACE,
    PLACE,
    RESIDUALS,
    STATES,
    VARIANCE,
    WEIGHT,
    BodyShape,
    cost,
    face_priors,
    odds_inside,
    residuals,
)
from tracker.detection.kernels.cholesky import factor, solve

TURN_MAX = math.radians(6.0)
"""Maximum turn in one iteration [rad]; the equations are linear in small angles."""
DEPTH_STD = 10.0
"""Standard deviation of the depth of a face without points [m]: it is unknown."""
HEADING_STD = 0.5 * math.pi / math.sqrt(12.0)
"""Standard deviation of a heading without points, uniform over a quarter turn [rad]."""


@kernel(error_model="numpy")
def weigh(found: Floats, scale: float, shape: BodyShape) -> None:
    """Write the weights of points: their probability of being on the face, over the variance; 0 for outliers."""
    for i in range(found.shape[1]):
        depth, variance = found[DEPTH, i], scale * scale * found[VARIANCE, i]
        if depth <= 0.0 and 0.5 * depth * depth > shape.cost_max * variance:
            found[WEIGHT, i] = 0.0
        else:
            found[WEIGHT, i] = 1.0 / (variance * (1.0 + odds_inside(depth, variance, shape)))


@kernel(inline="always", error_model="numpy")
def add_points(found: Floats, first: int, last: int, state: Floats, side: Floats, sums: Floats) -> None:
    """Add the points `first` to `last` to the weighted sums (2, 14) of their faces.

    The Jacobian of the depth d is (r, -1, s, t) by heading, depth, curvature and middle. Sums are those of 1, r, s, t,
    of d, rd, sd, td, and of rr, rs, rt, ss, st, tt.
    """
    for i in range(first, last):
        k = 0 if found[FACE, i] == 0.0 else 1
        d, w, offset = found[DEPTH, i], found[WEIGHT, i], found[PLACE, i] - state[3 + 3 * k]
        s, t = -offset * offset, 2.0 * state[2 + 3 * k] * offset
        r = t * found[ASIDE, i] + side[k] * found[PLACE, i]
        r = -r if k == 0 else r
        wr, ws, wt = w * r, w * s, w * t
        sums[k, 0] += w
        sums[k, 1] += wr
        sums[k, 2] += ws
        sums[k, 3] += wt
        sums[k, 4] += w * d
        sums[k, 5] += wr * d
        sums[k, 6] += ws * d
        sums[k, 7] += wt * d
        sums[k, 8] += wr * r
        sums[k, 9] += wr * s
        sums[k, 10] += wr * t
        sums[k, 11] += ws * s
        sums[k, 12] += ws * t
        sums[k, 13] += wt * t


@kernel(inline="always", error_model="numpy")
def add_line(sums: Floats, k: int, line_std: float, information: Floats, gradient: Floats) -> None:
    """Add a scan line on face k to the normal equations, without its offset, and clear its sums."""
    f = 1 + 3 * k
    kept = 1.0 / (1.0 + sums[k, 0] * line_std**2)  # the offset takes the rest
    share = kept * line_std**2
    information[0, 0] += sums[k, 8] - share * sums[k, 1] * sums[k, 1]
    information[f, 0] -= kept * sums[k, 1]
    information[f + 1, 0] += sums[k, 9] - share * sums[k, 1] * sums[k, 2]
    information[f + 2, 0] += sums[k, 10] - share * sums[k, 1] * sums[k, 3]
    information[f, f] += kept * sums[k, 0]
    information[f + 1, f] -= kept * sums[k, 2]
    information[f + 2, f] -= kept * sums[k, 3]
    information[f + 1, f + 1] += sums[k, 11] - share * sums[k, 2] * sums[k, 2]
    information[f + 2, f + 1] += sums[k, 12] - share * sums[k, 2] * sums[k, 3]
    information[f + 2, f + 2] += sums[k, 13] - share * sums[k, 3] * sums[k, 3]
    gradient[0] -= sums[k, 5] - share * sums[k, 1] * sums[k, 4]
    gradient[f] += kept * sums[k, 4]
    gradient[f + 1] -= sums[k, 6] - share * sums[k, 2] * sums[k, 4]
    gradient[f + 2] -= sums[k, 7] - share * sums[k, 3] * sums[k, 4]
    for a in range(sums.shape[1]):
        sums[k, a] = 0.0


@kernel(error_model="numpy")
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
    sums = np.zeros((2, 14))
    weigh(found, scale, shape)
    for g in range(len(start) - 1):
        add_points(found, start[g], start[g + 1], state, side, sums)
        for k in range(2):
            if sums[k, 0] > 0.0:
                add_line(sums, k, shape.line_std, information, gradient)
    information[0, 0] += 1.0 / HEADING_STD**2
    for k in range(2):
        information[1 + 3 * k, 1 + 3 * k] += 1.0 / DEPTH_STD**2
        for a in range(2):
            at, certainty = 2 + a + 3 * k, 1.0 / prior[k, 2 * a + 1] ** 2
            information[at, at] += certainty
            gradient[at] += (prior[k, 2 * a] - state[at]) * certainty


@kernel(error_model="numpy")
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
    found, prior, step = np.empty((RESIDUALS, len(points))), np.empty((2, 5)), np.empty(STATES)
    for turn in range(rounds + 1):  # the last one only writes what the cost needs
        residuals(points, ray, state, side, shape, found)
        face_priors(found, state, side, flank, shape, prior)
        if turn == rounds:
            break
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
    return cost(start, state, prior, flank, shape, found)

"""Kernels that fit a heading and two bowed faces to the points of a body, by iteratively reweighted least squares.

The offset of each scan line on each face is eliminated from the normal equations (Woodbury's identity).
"""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.bowed_faces import (
    ASIDE,
    DEPTH,
    FACE,
    PLACE,
    RESIDUALS,
    STATES,
    VARIANCE,
    WEIGHT,
    Beams,
    BodyShape,
    cost,
    face_priors,
    odds_inside,
    residuals,
)
from luxloop.tracker.detection.kernels.cholesky import factor, solve

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
def add_line(
    found: Floats, first: int, last: int, k: int, state: Floats, side: Floats, line_std: float, information: Floats,
    gradient: Floats,
) -> None:  # fmt: skip
    """Add the points `first` to `last` on face k, a scan line, to the normal equations, without the line's offset.

    The Jacobian of the depth d is (r, -1, s, t) by heading, depth, curvature and middle.
    """
    f = 1 + 3 * k
    bow, middle, sign = 2.0 * state[f + 1], state[f + 2], side[k]
    sum_1, sum_r, sum_s, sum_t, sum_d, sum_rd, sum_sd, sum_td = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    sum_rr, sum_rs, sum_rt, sum_ss, sum_st, sum_tt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # all are weighted
    for i in range(first, last):
        if found[FACE, i] == k:
            d, w, offset = found[DEPTH, i], found[WEIGHT, i], found[PLACE, i] - middle
            s, t = -offset * offset, bow * offset
            r = t * found[ASIDE, i] + sign * found[PLACE, i]
            r = -r if k == 0 else r
            wr, ws, wt = w * r, w * s, w * t
            sum_1, sum_r, sum_s, sum_t = sum_1 + w, sum_r + wr, sum_s + ws, sum_t + wt
            sum_d, sum_rd, sum_sd, sum_td = sum_d + w * d, sum_rd + wr * d, sum_sd + ws * d, sum_td + wt * d
            sum_rr, sum_rs, sum_rt = sum_rr + wr * r, sum_rs + wr * s, sum_rt + wr * t
            sum_ss, sum_st, sum_tt = sum_ss + ws * s, sum_st + ws * t, sum_tt + wt * t
    if sum_1 <= 0.0:
        return
    kept = 1.0 / (1.0 + sum_1 * line_std**2)  # the offset takes the rest
    share = kept * line_std**2
    information[0, 0] += sum_rr - share * sum_r * sum_r
    information[f, 0] -= kept * sum_r
    information[f + 1, 0] += sum_rs - share * sum_r * sum_s
    information[f + 2, 0] += sum_rt - share * sum_r * sum_t
    information[f, f] += kept * sum_1
    information[f + 1, f] -= kept * sum_s
    information[f + 2, f] -= kept * sum_t
    information[f + 1, f + 1] += sum_ss - share * sum_s * sum_s
    information[f + 2, f + 1] += sum_st - share * sum_s * sum_t
    information[f + 2, f + 2] += sum_tt - share * sum_t * sum_t
    gradient[0] -= sum_rd - share * sum_r * sum_d
    gradient[f] += kept * sum_d
    gradient[f + 1] -= sum_sd - share * sum_s * sum_d
    gradient[f + 2] -= sum_td - share * sum_t * sum_d


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
    weigh(found, scale, shape)
    for g in range(len(start) - 1):
        for k in range(2):
            add_line(found, start[g], start[g + 1], k, state, side, shape.line_std, information, gradient)
    information[0, 0] += 1.0 / HEADING_STD**2
    for k in range(2):
        information[1 + 3 * k, 1 + 3 * k] += 1.0 / DEPTH_STD**2
        for a in range(2):
            at, certainty = 2 + a + 3 * k, 1.0 / prior[k, 2 * a + 1] ** 2
            information[at, at] += certainty
            gradient[at] += (prior[k, 2 * a] - state[at]) * certainty


@kernel(error_model="numpy")
def fit_body(
    beams: Beams,
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
    found, prior, step = np.empty((RESIDUALS, len(beams.x))), np.empty((2, 5)), np.empty(STATES)
    for turn in range(rounds + 1):  # the last one only writes what the cost needs
        residuals(beams, state, side, shape, found)
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

"""Kernels of bowed faces: depths of points behind two perpendicular faces, each a parabola in plan, and their cost.

Face 0 runs along the heading, face 1 across it. With the middle c of a face and its depth d there, a point at place a
along the face lies d + k (a - c)^2 deep, where k is the curvature. A state (7,) is the heading, then d, k and c of each
face, about the mean of the points. Layers meet the body at different heights, therefore each scan line has an offset of
its own on each face. Points inside the body, seen through glass or over the hood, have an exponential tail.

Points are sorted by scan line: line g has points start[g] to start[g + 1].
"""

import math
from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel

STATES = 7
RESIDUALS = 6
DEPTH, VARIANCE, PLACE, ASIDE, FACE, WEIGHT = range(RESIDUALS)
"""Rows of the residuals: depth behind the face [m], its variance [m^2], place along the face and coordinate across it
[m], number of the face, and weight in the normal equations."""
FLATNESS_M = 0.02
"""Standard deviation of points across a face without range noise [m]: single scan lines scatter by 2.0 cm on the flanks
of real cars."""
LINE_STD_M = 0.1
"""Standard deviation of the depth of a scan line on a face [m]: bumper, hood and glass are decimetres apart (median of
real cars between the layers: 0.2 to 0.3 m from lowest to highest)."""
INSIDE_M = 1.0
"""Mean depth of points inside the body [m]: windscreens lie 0.9 to 1.2 m behind the bumper."""
INSIDE_FRACTION = 0.03
"""Fraction of points inside the body, at the depth of a face."""
COST_MAX = 6.0
"""Cost of an outlier: that of a point 3.5 standard deviations off."""
FLANK_CURVATURE_PER_M = 0.02
"""Curvature of flanks [1/m]: 0.027 for real cars (7 cm over 1.6 m to either side), 0 for trucks."""
FLANK_CURVATURE_STD_PER_M = 0.02
"""Its standard deviation [1/m]."""
END_CURVATURE_PER_M = 0.22
"""Curvature of fronts and rears [1/m], 12 cm over 0.75 m to either side of the middle: 0.17 to 0.42 for real cars by
height, 0 for trucks."""
END_CURVATURE_STD_PER_M = 0.5
"""Its standard deviation [1/m]: arcs of hoods and greenhouses are bowed twice as much."""
FLANK_LENGTH_M = 4.4
"""Length of a flank that is visible in part [m]: a medium-sized car."""
END_LENGTH_M = 1.8
"""Length of an end that is visible in part [m]: the width of cars."""
FLANK_WHOLE_MIN_M = 3.0
"""Minimum visible length of a whole flank [m]: the shortest cars measure 2.7 to 3.6."""
END_WHOLE_MIN_M = 1.4
"""Minimum visible length of a whole end [m]: car width less two rounded corners."""
FLANK_MIDDLE_STD_M = 0.3
"""Standard deviation of the middle of a whole flank [m]: wheel arches and corners hide its ends."""
END_MIDDLE_STD_M = 0.08
"""The same of a whole end [m]: its shape is symmetric."""
PART_MIDDLE_STD_M = 0.8
"""Standard deviation of the middle of a face that is visible in part [m]: half the width of a car."""
WIDTH_MAX_M = 2.4
"""Maximum visible length of an end [m]: trucks measure 2.55 between the rounded edges."""
LINE_GATE = 4.0
"""Gate on the points that give a scan line its offset, in standard deviations."""
EXPONENT_MAX = 40.0
"""Maximum exponent of a likelihood, against underflow."""
TURN_MAX = math.radians(6.0)
"""Maximum turn in one iteration [rad]; the equations are linear in small angles."""
DEPTH_STD = 10.0
"""Standard deviation of the depth of a face without points [m]: it is unknown."""
HEADING_STD = 0.5 * math.pi / math.sqrt(12.0)
"""Standard deviation of a heading without points, uniform over a quarter turn [rad]."""


class BodyShape(NamedTuple):
    """Distributions of the shape of vehicles, and of points about their faces. Flanks come first, ends second.

    Tuples, not arrays: kernels would count the references to arrays at each call.
    """

    range_std: float
    """Range noise along the beam [m]."""
    flatness: float = FLATNESS_M
    line_std: float = LINE_STD_M
    inside: float = INSIDE_M
    inside_share: float = INSIDE_FRACTION
    cost_max: float = COST_MAX
    curvature: tuple[tuple[float, float], tuple[float, float]] = (
        (FLANK_CURVATURE_PER_M, FLANK_CURVATURE_STD_PER_M),
        (END_CURVATURE_PER_M, END_CURVATURE_STD_PER_M),
    )
    """Mean and standard deviation [1/m]."""
    length: tuple[float, float] = (FLANK_LENGTH_M, END_LENGTH_M)
    whole_min: tuple[float, float] = (FLANK_WHOLE_MIN_M, END_WHOLE_MIN_M)
    middle_std: tuple[tuple[float, float], tuple[float, float]] = (
        (PART_MIDDLE_STD_M, FLANK_MIDDLE_STD_M),
        (PART_MIDDLE_STD_M, END_MIDDLE_STD_M),
    )
    """Of a face that is visible in part, and of a whole one [m]."""
    width_max: float = WIDTH_MAX_M


class Beams(NamedTuple):
    """Points (N,) about their mean, and unit vectors of their beams (N,), each contiguous."""

    x: Floats
    y: Floats
    ray_x: Floats
    ray_y: Floats


@kernel(error_model="numpy")
def residuals(beams: Beams, state: Floats, side: Floats, shape: BodyShape, found: Floats) -> None:
    """Assign each point to the face that it is less deep behind, in standard deviations: a body is convex.

    Parameters
    ----------
    side
        (2,) 1 for a face on the low side of its axis, -1 on the high one.
    found
        (RESIDUALS, N) output, all rows but the weights.
    """
    cos, sin, flat, noise = math.cos(state[0]), math.sin(state[0]), shape.flatness**2, shape.range_std**2
    start_0, curve_0, middle_0 = state[1], state[2], state[3]  # read before the loop, which then vectorises
    start_1, curve_1, middle_1 = state[4], state[5], state[6]
    sign_0, sign_1 = side[0], side[1]
    x, y, ray_x, ray_y = beams
    for i in range(len(x)):
        along, across = cos * x[i] + sin * y[i], cos * y[i] - sin * x[i]
        ray_along, ray_across = cos * ray_x[i] + sin * ray_y[i], cos * ray_y[i] - sin * ray_x[i]
        variance_0, variance_1 = noise * ray_across * ray_across + flat, noise * ray_along * ray_along + flat
        bow_0, bow_1 = along - middle_0, across - middle_1
        depth_0 = sign_0 * across - start_0 - curve_0 * bow_0 * bow_0
        depth_1 = sign_1 * along - start_1 - curve_1 * bow_1 * bow_1
        first = depth_0 * abs(depth_0) * variance_1 <= depth_1 * abs(depth_1) * variance_0  # squares keep their sign
        found[DEPTH, i] = depth_0 if first else depth_1
        found[VARIANCE, i] = variance_0 if first else variance_1
        found[PLACE, i] = along if first else across
        found[ASIDE, i] = across if first else along
        found[FACE, i] = 0.0 if first else 1.0


@kernel(inline="always", error_model="numpy")
def odds_inside(depth: float, variance: float, shape: BodyShape) -> float:
    """Return the likelihood that a point is inside the body over that of being on the face; 0 in front of the face."""
    if depth <= 0.0:
        return 0.0
    exponent = min(0.5 * depth * depth / variance, EXPONENT_MAX) - depth / shape.inside
    return shape.inside_share / (1.0 - shape.inside_share) * math.exp(exponent)


@kernel(error_model="numpy")
def face_priors(found: Floats, state: Floats, side: Floats, flank: int, shape: BodyShape, prior: Floats) -> None:
    """Write curvature, its std, middle, its std, and visible length of each face before the fit to `prior` (2, 5).

    A face begins at the other one and ends at its last point. The middle of a whole face is between both; that of a
    face that is visible in part follows from the usual length.
    """
    for k in range(2):
        near, far, sign = np.inf, -np.inf, side[1 - k]
        for i in range(found.shape[1]):  # no branch: which points are near is hard to predict
            depth = found[DEPTH, i]
            is_near = (depth < 2.0 * shape.line_std) & ((depth > 0.0) | (depth * depth < 9.0 * found[VARIANCE, i]))
            is_near &= found[FACE, i] == k
            place = sign * found[PLACE, i]
            near, far = min(near, place if is_near else np.inf), max(far, place if is_near else -np.inf)
        corner, kind = state[4 - 3 * k], 0 if k == flank else 1
        whole = far - corner > shape.whole_min[kind]
        length = far - corner if whole else shape.length[kind]
        prior[k, 0], prior[k, 1] = shape.curvature[kind]
        prior[k, 2], prior[k, 3] = side[1 - k] * (corner + 0.5 * length), shape.middle_std[kind][1 if whole else 0]
        prior[k, 4] = max(far - near, 0.0)


@kernel(inline="always", error_model="numpy")
def line_offset(found: Floats, first: int, last: int, k: int, shape: BodyShape) -> float:
    """Return the likeliest depth of points `first` to `last`, a scan line, on face k [m]."""
    weight, depth = 1.0 / shape.line_std**2, 0.0
    for i in range(first, last):
        if found[FACE, i] == k:
            beyond = abs(found[DEPTH, i]) - 2.0 * shape.line_std
            if beyond < 0.0 or beyond * beyond < LINE_GATE**2 * found[VARIANCE, i]:
                weight, depth = weight + 1.0 / found[VARIANCE, i], depth + found[DEPTH, i] / found[VARIANCE, i]
    return depth / weight


@kernel(error_model="numpy")
def cost(start: Ints, state: Floats, prior: Floats, flank: int, shape: BodyShape, found: Floats) -> float:
    """Return the negative log-likelihood of points and priors, with the likeliest offset of each scan line."""
    total, on_face = 0.0, -math.log(1.0 - shape.inside_share)
    for g in range(len(start) - 1):
        offset_0 = line_offset(found, start[g], start[g + 1], 0, shape)
        offset_1 = line_offset(found, start[g], start[g + 1], 1, shape)
        total += 0.5 * (offset_0 / shape.line_std) ** 2
        total += 0.5 * (offset_1 / shape.line_std) ** 2
        for i in range(start[g], start[g + 1]):
            depth, variance = found[DEPTH, i] - (offset_0 if found[FACE, i] == 0.0 else offset_1), found[VARIANCE, i]
            inside = math.log1p(odds_inside(depth, variance, shape)) if depth > 0.0 else 0.0
            total += min(min(0.5 * depth * depth / variance, EXPONENT_MAX) + on_face - inside, shape.cost_max)
    for k in range(2):
        for a in range(2):
            total += 0.5 * ((state[2 + a + 3 * k] - prior[k, 2 * a]) / prior[k, 2 * a + 1]) ** 2
    return float(total + 0.5 * (max(prior[1 - flank, 4] - shape.width_max, 0.0) / shape.line_std) ** 2)


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
    found: Floats, first: int, last: int, k: int, state: Floats, side: Floats, line_std: float,
    equations: tuple[Floats, Floats],
) -> None:  # fmt: skip
    """Add the points `first` to `last` on face k, a scan line, to the normal equations, without the line's offset.

    The Jacobian of the depth d is (r, -1, s, t) by heading, depth, curvature and middle.
    """
    f, (information, gradient) = 1 + 3 * k, equations
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
    equations: tuple[Floats, Floats],
) -> None:
    """Write information matrix (7, 7), lower triangle, and gradient (7,) of the state, with priors, without offsets."""
    information, gradient = equations
    information[:], gradient[:] = 0.0, 0.0
    weigh(found, scale, shape)
    for g in range(len(start) - 1):
        for k in range(2):
            add_line(found, start[g], start[g + 1], k, state, side, shape.line_std, equations)
    information[0, 0] += 1.0 / HEADING_STD**2
    for k in range(2):
        information[1 + 3 * k, 1 + 3 * k] += 1.0 / DEPTH_STD**2
        for a in range(2):
            at, certainty = 2 + a + 3 * k, 1.0 / prior[k, 2 * a + 1] ** 2
            information[at, at] += certainty
            gradient[at] += (prior[k, 2 * a] - state[at]) * certainty


class Schedule(NamedTuple):
    """Rounds of a fit."""

    rounds: int
    scale: float
    """Factor of the noise in the first round, halved from round to round down to 1: a narrow start finds local minima.
    Above 1, curvature and middle of the faces start at their priors."""


@kernel(error_model="numpy")
def fit_body(
    beams: Beams,
    start: Ints,
    state: Floats,
    side: Floats,
    flank: int,
    schedule: Schedule,
    shape: BodyShape,
    information: Floats,
) -> float:
    """Improve a state (7,); return its cost, and write the Cholesky factor of its information matrix (7, 7).

    Parameters
    ----------
    flank
        Face that is a flank; the other is a front or rear.
    """
    rounds, scale = schedule
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
        normal_equations(start, state, side, prior, noise_scale, shape, found, (information, step))
        factor(information)
        solve(information, step)
        shortened = min(1.0, TURN_MAX / max(abs(step[0]), 1e-12))
        for a in range(STATES):
            state[a] += step[a] * shortened
    return cost(start, state, prior, flank, shape, found)


@kernel(error_model="numpy")
def factor(matrix: Floats) -> None:
    """Replace the lower triangle of a symmetric positive definite matrix (n, n) by its Cholesky factor."""
    for i in range(len(matrix)):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = math.sqrt(rest) if i == j else rest / matrix[j, j]


@kernel(error_model="numpy")
def solve(triangle: Floats, vector: Floats) -> None:
    """Replace a vector (n,) by the solution x of L L^T x = vector, with the Cholesky factor L in `triangle`."""
    for i in range(len(vector)):
        rest = vector[i]
        for k in range(i):
            rest -= triangle[i, k] * vector[k]
        vector[i] = rest / triangle[i, i]
    for i in range(len(vector) - 1, -1, -1):
        rest = vector[i]
        for k in range(i + 1, len(vector)):
            rest -= triangle[k, i] * vector[k]
        vector[i] = rest / triangle[i, i]

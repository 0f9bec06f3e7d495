"""Kernels of bowed faces: fit a heading and two perpendicular faces, each a parabola in plan, to the points of a body.

Face 0 runs along the heading, face 1 across it. With the middle c of a face and its depth d there, a point at place a
along the face lies d + k (a - c)^2 deep, where k is the curvature. A state (7,) is the heading, then d, k and c of each
face, about the mean of the points. Layers meet the body at different heights, therefore each scan line has an offset of
its own on each face, which is eliminated from the normal equations (Woodbury's identity). Points inside the body, seen
through glass or over the hood, have an exponential tail.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.cholesky import factor, solve

STATES = 7
OF_FACE = np.array([[0, 1, 2, 3], [0, 4, 5, 6]])
"""States that the depth of a point on each face depends on."""
SHALLOW_SHARE = 0.08
"""Share of the points in front of a face at its start: mirrors and range outliers."""
TURN_MAX = math.radians(6.0)
"""Maximum turn in one iteration [rad]; the equations are linear in small angles."""
LINE_GATE = 4.0
"""Gate on the points that give a scan line its offset, in standard deviations."""
DEPTH_STD = 10.0
"""Standard deviation of the depth of a face without points [m]: it is unknown."""
HEADING_STD = 0.5 * math.pi / math.sqrt(12.0)
"""Standard deviation of a heading without points, uniform over a quarter turn [rad]."""


class BodyShape(NamedTuple):
    """Distributions of the shape of vehicles, and of points about their faces. Flanks come first, ends second."""

    range_std: float
    """Range noise along the beam [m]."""
    flatness: float
    """Standard deviation of points across a face for all other reasons [m]."""
    line_std: float
    """Standard deviation of the depth of a scan line on a face [m]."""
    inside: float
    """Mean depth of points inside the body [m]."""
    inside_share: float
    """Share of points inside the body."""
    cost_max: float
    """Cost of an outlier."""
    curvature: Floats
    """(2, 2) mean and standard deviation of the curvature [1/m]."""
    length: Floats
    """(2,) length of a face that is visible in part [m]."""
    whole_min: Floats
    """(2,) minimum visible length of a whole face [m]."""
    middle_std: Floats
    """(2, 2) standard deviation of the middle of a face that is visible in part, and of a whole one [m]."""
    width_max: float
    """Maximum length of an end [m]."""


@njit(cache=True)
def residuals(points: Floats, ray: Floats, state: Floats, side: Floats, shape: BodyShape, found: Floats) -> None:
    """Assign each point to the face that it is less deep behind, in standard deviations: a body is convex.

    Parameters
    ----------
    points, ray
        (N, 2) about their mean [m], and unit vectors of their beams.
    side
        (2,) 1 for a face on the low side of its axis, -1 on the high one.
    found
        (N, 4) output: depth behind the face, its standard deviation and the place along the face [m], and the face.
    """
    cos, sin, flat = math.cos(state[0]), math.sin(state[0]), shape.flatness**2
    for i in range(len(points)):
        along, across = cos * points[i, 0] + sin * points[i, 1], cos * points[i, 1] - sin * points[i, 0]
        ray_along, ray_across = cos * ray[i, 0] + sin * ray[i, 1], cos * ray[i, 1] - sin * ray[i, 0]
        std_0 = math.sqrt((shape.range_std * ray_across) ** 2 + flat)
        std_1 = math.sqrt((shape.range_std * ray_along) ** 2 + flat)
        depth_0 = side[0] * across - state[1] - state[2] * (along - state[3]) ** 2
        depth_1 = side[1] * along - state[4] - state[5] * (across - state[6]) ** 2
        if depth_0 * std_1 <= depth_1 * std_0:
            found[i, 0], found[i, 1], found[i, 2], found[i, 3] = depth_0, std_0, along, 0.0
        else:
            found[i, 0], found[i, 1], found[i, 2], found[i, 3] = depth_1, std_1, across, 1.0


@njit(cache=True)
def likelihood(depth: float, std: float, shape: BodyShape) -> tuple[float, float]:
    """Return the likelihoods that a point is on the face and inside the body, relative to the top of the former."""
    on_face = (1.0 - shape.inside_share) * math.exp(-0.5 * min((depth / std) ** 2, 80.0))
    return on_face, shape.inside_share * math.exp(-depth / shape.inside) if depth > 0.0 else 0.0


@njit(cache=True)
def face_priors(found: Floats, state: Floats, side: Floats, flank: int, shape: BodyShape) -> Floats:
    """Return curvature, its std, middle, its std, and visible length (2, 5) of each face before the fit.

    A face begins at the other one and ends at its last point. The middle of a whole face is between both; that of a
    face that is visible in part follows from the usual length.
    """
    prior = np.empty((2, 5))
    for k in range(2):
        corner, toward, kind = state[4 - 3 * k], side[1 - k], 0 if k == flank else 1
        near, far = np.inf, -np.inf
        for i in range(len(found)):
            if found[i, 3] == k and -3.0 * found[i, 1] < found[i, 0] < 2.0 * shape.line_std:
                near, far = min(near, toward * found[i, 2]), max(far, toward * found[i, 2])
        whole = far - corner > shape.whole_min[kind]
        length = far - corner if whole else shape.length[kind]
        prior[k, 0], prior[k, 1] = shape.curvature[kind]
        prior[k, 2], prior[k, 3] = toward * (corner + 0.5 * length), shape.middle_std[kind, 1 if whole else 0]
        prior[k, 4] = max(far - near, 0.0)
    return prior


@njit(cache=True)
def normal_equations(
    points: Floats,
    line: Ints,
    lines: int,
    state: Floats,
    side: Floats,
    prior: Floats,
    scale: float,
    shape: BodyShape,
    found: Floats,
) -> tuple[Floats, Floats]:
    """Return the information matrix (7, 7) and the gradient (7,) of the state, with priors, without line offsets."""
    information, gradient, row = np.zeros((STATES, STATES)), np.zeros(STATES), np.empty(4)
    row_sum, weight_sum, depth_sum = np.zeros((2, lines, 4)), np.zeros((2, lines)), np.zeros((2, lines))
    cos, sin = math.cos(state[0]), math.sin(state[0])
    for i in range(len(points)):
        depth, std, k = found[i, 0], scale * found[i, 1], int(found[i, 3])
        if depth < 0.0 and 0.5 * (depth / std) ** 2 > shape.cost_max:
            continue
        on_face, inside = likelihood(depth, std, shape)
        weight = on_face / (on_face + inside) / std**2
        along, across = cos * points[i, 0] + sin * points[i, 1], cos * points[i, 1] - sin * points[i, 0]
        offset, lever = found[i, 2] - state[3 + 3 * k], -across if k == 0 else along
        slope = 2.0 * state[2 + 3 * k] * offset
        row[0] = (-side[0] * along if k == 0 else side[1] * across) + slope * lever
        row[1], row[2], row[3] = -1.0, -offset * offset, slope
        for a in range(4):
            gradient[OF_FACE[k, a]] -= weight * row[a] * depth
            row_sum[k, line[i], a] += weight * row[a]
            for b in range(a + 1):
                information[OF_FACE[k, a], OF_FACE[k, b]] += weight * row[a] * row[b]
        weight_sum[k, line[i]] += weight
        depth_sum[k, line[i]] += weight * depth
    for k in range(2):
        for g in range(lines):
            share = 1.0 / (shape.line_std**-2.0 + weight_sum[k, g])
            for a in range(4):
                gradient[OF_FACE[k, a]] += share * row_sum[k, g, a] * depth_sum[k, g]
                for b in range(a + 1):
                    information[OF_FACE[k, a], OF_FACE[k, b]] -= share * row_sum[k, g, a] * row_sum[k, g, b]
        information[1 + 3 * k, 1 + 3 * k] += DEPTH_STD**-2.0
        for a in range(2):
            at, certainty = 2 + a + 3 * k, prior[k, 2 * a + 1] ** -2.0
            information[at, at] += certainty
            gradient[at] += (prior[k, 2 * a] - state[at]) * certainty
    information[0, 0] += HEADING_STD**-2.0
    return information, gradient


@njit(cache=True)
def cost(line: Ints, lines: int, state: Floats, prior: Floats, flank: int, shape: BodyShape, found: Floats) -> float:
    """Return the negative log-likelihood of points and priors, with the likeliest offset of each scan line."""
    weight, offset = np.full((2, lines), shape.line_std**-2.0), np.zeros((2, lines))
    for i in range(len(found)):
        if abs(found[i, 0]) < LINE_GATE * found[i, 1] + 2.0 * shape.line_std:
            weight[int(found[i, 3]), line[i]] += found[i, 1] ** -2.0
            offset[int(found[i, 3]), line[i]] += found[i, 0] * found[i, 1] ** -2.0
    offset /= weight
    total = 0.5 * np.sum(offset * offset) / shape.line_std**2
    for i in range(len(found)):
        on_face, inside = likelihood(found[i, 0] - offset[int(found[i, 3]), line[i]], found[i, 1], shape)
        total += min(-math.log(max(on_face + inside, 1e-30)), shape.cost_max)
    for k in range(2):
        for a in range(2):
            total += 0.5 * ((state[2 + a + 3 * k] - prior[k, 2 * a]) / prior[k, 2 * a + 1]) ** 2
    return float(total + 0.5 * (max(prior[1 - flank, 4] - shape.width_max, 0.0) / shape.line_std) ** 2)


@njit(cache=True)
def first_state(points: Floats, heading: float, side: Floats) -> Floats:
    """Return the state (7,) of flat faces at a heading, behind a small share of the points."""
    state, cos, sin = np.zeros(STATES), math.cos(heading), math.sin(heading)
    shallow = int(SHALLOW_SHARE * len(points))
    state[0] = heading
    state[1] = np.sort(side[0] * (cos * points[:, 1] - sin * points[:, 0]))[shallow]
    state[4] = np.sort(side[1] * (cos * points[:, 0] + sin * points[:, 1]))[shallow]
    return state


@njit(cache=True)
def fit_body(
    points: Floats,
    ray: Floats,
    line: Ints,
    state: Floats,
    side: Floats,
    flank: int,
    rounds: int,
    scale: float,
    shape: BodyShape,
) -> tuple[float, Floats]:
    """Improve a state (7,) by iteratively reweighted least squares; return its cost and information matrix (7, 7).

    Parameters
    ----------
    line
        (N,) scan line of each point, 0 and up.
    flank
        Face that is a flank; the other is a front or rear.
    scale
        Factor of the noise in the first round, halved from round to round down to 1: a narrow start finds local
        minima. Above 1, curvature and middle of the faces start at their priors.
    """
    found, information, lines = np.empty((len(points), 4)), np.eye(STATES), line.max() + 1
    for turn in range(rounds):
        residuals(points, ray, state, side, shape, found)
        prior = face_priors(found, state, side, flank, shape)
        if turn == 0 and scale > 1.0:
            for k in range(2):
                state[2 + 3 * k], state[3 + 3 * k] = prior[k, 0], prior[k, 2]
        noise_scale = max(1.0, scale * 0.5**turn)
        information, step = normal_equations(points, line, lines, state, side, prior, noise_scale, shape, found)
        factor(information)
        solve(information, step)
        state += step * min(1.0, TURN_MAX / max(abs(step[0]), 1e-12))
    residuals(points, ray, state, side, shape, found)
    prior = face_priors(found, state, side, flank, shape)
    return cost(line, lines, state, prior, flank, shape, found), information

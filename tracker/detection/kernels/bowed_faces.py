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
LINE_GATE = 4.0
"""Gate on the points that give a scan line its offset, in standard deviations."""
EXPONENT_MAX = 40.0
"""Maximum exponent of a likelihood, against underflow."""


class BodyShape(NamedTuple):
    """Distributions of the shape of vehicles, and of points about their faces. Flanks come first, ends second.

    Tuples, not arrays: kernels would count the references to arrays at each call.
    """

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
    curvature: tuple[tuple[float, float], tuple[float, float]]
    """Mean and standard deviation of the curvature [1/m]."""
    length: tuple[float, float]
    """Length of a face that is visible in part [m]."""
    whole_min: tuple[float, float]
    """Minimum visible length of a whole face [m]."""
    middle_std: tuple[tuple[float, float], tuple[float, float]]
    """Standard deviation of the middle of a face that is visible in part, and of a whole one [m]."""
    width_max: float
    """Maximum length of an end [m]."""


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

"""Body fit: heading and covariance of the vehicle of each segment, by faces that are bowed like those of real cars."""

import math
from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.alignment import FLATNESS_M, REACH_M, misalignments
from luxloop.tracker.detection.bowed_faces import STATES, Beams, BodyShape, Schedule, fit_body, solve
from luxloop.tracker.detection.point_groups import by_group, columns, even_subset, means
from luxloop.tracker.free_space import UNIT_OFFSET_M
from luxloop.tracker.records import SegmentedPoints

ALIGNMENT_WEIGHT = 4.0
"""Weight of the density of points along the faces, which needs no model of their shape, beside this model."""
TEMPERATURE = 5.0
"""Difference of cost at which another result is e times less likely. Points are correlated, so it is above 1."""
ASYMMETRY_STD_RAD = 0.005
"""Standard deviation of the heading for reasons outside the model [rad]: flanks converge by 2 cm over a car."""
SAMPLE_MAX = 48
"""Points of the first fits; the last ones use all points."""
FIRST_FITS = Schedule(rounds=4, scale=4.0)
"""First fits, at 4, 2, 1 and 1 times the noise."""
LAST_MAX = 3
"""Maximum number of hypotheses that are fitted to all points."""
PLAUSIBLE = 15.0
"""Maximum difference of their costs in the first fit from the least one."""
LAST_FITS = Schedule(rounds=2, scale=1.0)
"""Fits to all points."""
QUARTER = 0.5 * math.pi
APART = math.radians(2.0)
"""Minimum difference of two starts [rad]; nearer ones lead to the same result."""
STARTS_MAX = 3
"""Maximum number of starts; more find no better result."""
HYPOTHESES_MAX = 8 * STARTS_MAX
"""Two places of the flank for each of up to four corners of a body beside the ego."""
SHALLOW_FRACTION = 0.08
"""Share of the points in front of a face at its start: mirrors and range outliers."""
COST, HEADING_VARIANCE, SIDE, FLANK, STATE = 0, 1, 2, 4, 5
"""Columns of a hypothesis (STATE + STATES,): cost, variance of the heading [rad^2], sides (2,), flank, and state."""


class BodyFit(NamedTuple):
    """Bodies of S segments."""

    heading: Floats
    """(S,) modulo a quarter turn, ego frame [rad]."""
    cost: Floats
    """(S,) cost per point."""
    covariance: Floats
    """(S, 3, 3) of x, y [m] and heading [rad], ego frame, of a body that turns about the mean of its points."""


def fit(points: SegmentedPoints, heading: Floats, range_std_m: float) -> BodyFit:
    """Fit the body of each segment, from the best of its candidate headings (S, M).

    The cost is the negative log-likelihood of the points under `bowed_faces`, with a range noise `range_std_m` [m],
    plus the weighted misalignment. The order of the points has no effect.
    """
    found = search_bodies(points, np.ascontiguousarray(heading), BodyShape(range_std_m))
    found.covariance[:, 2, 2] += ASYMMETRY_STD_RAD**2
    return found


def search_bodies(points: SegmentedPoints, heading: Floats, shape: BodyShape) -> BodyFit:
    """Find the body of each of S segments from candidates (S, M) [rad]."""
    found, owner = plausible_fits(points, heading, shape)
    segment, offset = points.label, points.offset
    order = by_line(points.scan_line, segment)
    xy, line, size = points.xy.take(order, axis=0), points.scan_line.take(order), np.diff(offset)
    center = means(xy, segment, len(heading))
    triangle = fit_bodies(xy, line, offset, center, found, owner, LAST_FITS, shape)
    aligned = misalignments(xy, offset, found[:, STATE].copy(), owner, directions(center), REACH_M, FLATNESS_M)
    found[:, COST] += ALIGNMENT_WEIGHT * size[owner] * aligned
    best, covariance, turn = best_bodies(found, first_of_each(owner, len(heading)), triangle, TEMPERATURE)
    return BodyFit(found[best, STATE], found[best, COST] / size, turn @ covariance @ turn.transpose(0, 2, 1))


def plausible_fits(points: SegmentedPoints, heading: Floats, shape: BodyShape) -> tuple[Floats, Ints]:
    """Fit bodies to subsets of segments from the best aligned headings; return the cheapest ones, and their segments.

    Faces are flat at first, behind a small fraction of the points.
    """
    segment = points.label
    center = means(points.xy, segment, len(heading))
    chosen, first = even_subset(points.xy, points.offset, SAMPLE_MAX)
    chosen = chosen[by_line(points.scan_line[chosen], segment[chosen])]
    sample, candidates = points.xy.take(chosen, axis=0), np.repeat(np.arange(len(heading)), heading.shape[1])
    aligned = misalignments(sample, first, heading.ravel(), candidates, directions(center), REACH_M, FLATNESS_M)
    order = np.argsort(aligned.reshape(heading.shape), axis=1, kind="stable")
    found, owner = first_hypotheses(sample, first, center, heading, order)
    fit_bodies(sample, points.scan_line[chosen], first, center, found, owner, FIRST_FITS, shape)
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
    return near & (np.arange(len(cost)) - leader < LAST_MAX)


def first_of_each(owner: Ints, count: int) -> Ints:
    """(count + 1,) first hypothesis of each segment in the ascending `owner` (H,), and H."""
    return np.searchsorted(owner, np.arange(count + 1))


@kernel(error_model="numpy")
def quarter_difference(a: float, b: float) -> float:
    """Return the difference of two headings modulo a quarter turn, in [-pi/4, pi/4] [rad]."""
    turn = (a - b) / QUARTER
    return QUARTER * (turn - math.floor(turn + 0.5))


@kernel(error_model="numpy")
def distinct_starts(heading: Floats, order: Ints, starts: Floats) -> int:
    """Write up to `STARTS_MAX` of the headings (M,) that are apart from each other, in this order; return their number.

    `order` (M,) begins with the cheapest heading.
    """
    count = 0
    for m in order:
        apart = count < STARTS_MAX
        for j in range(count):
            apart = apart and abs(quarter_difference(heading[m], starts[j])) > APART
        if apart:
            starts[count] = heading[m]
            count += 1
    return count


@kernel(error_model="numpy")
def shallow_depth(place: Floats, rank: int) -> float:
    """Return the value that `rank` others of `place` (N,) are below, or equal to; ranks are small."""
    least, count = np.empty(rank + 1), 0
    for value in place:
        if count <= rank or value < least[rank]:
            at = min(count, rank)
            while at > 0 and least[at - 1] > value:
                least[at] = least[at - 1]
                at -= 1
            least[at] = value
            count = min(count + 1, rank + 1)
    return float(least[rank])


@kernel(error_model="numpy")
def shallow_depths(points: Floats, center: Floats, heading: float, depth: Floats) -> None:
    """Write the depth (2, 2) of flat faces along and across a heading, each on the low and on the high side.

    Depths are about the `center` (2,), on the low side of an axis first; infinite for a side that does not face the
    ego. Units at different ends of the ego may see either side of a body beside it.
    """
    cos, sin, place = math.cos(heading), math.sin(heading), np.empty(len(points))
    for face in range(2):
        total = 0.0
        for i in range(len(points)):
            x, y = points[i, 0], points[i, 1]
            total += cos * y - sin * x if face == 0 else cos * x + sin * y
        mean = total / len(points)
        for high in range(2):
            sign = 1.0 - 2.0 * high
            if abs(mean) >= UNIT_OFFSET_M and (mean > 0.0) != (sign > 0.0):
                depth[face, high] = np.inf
                continue
            for i in range(len(points)):
                x, y = points[i, 0] - center[0], points[i, 1] - center[1]
                place[i] = sign * (cos * y - sin * x if face == 0 else cos * x + sin * y)
            depth[face, high] = shallow_depth(place, int(SHALLOW_FRACTION * len(points)))


@kernel(error_model="numpy")
def first_hypotheses(points: Floats, offset: Ints, center: Floats, heading: Floats, order: Ints) -> tuple[Floats, Ints]:
    """Return hypotheses (H, STATE + STATES) of bodies with flat faces, and the segment of each (H,).

    Each has one of the best headings of its segment, one pair of visible sides, and one place of the flank.

    Parameters
    ----------
    points, offset
        (N, 2) grouped by segment [m]; (S + 1,) first point of each segment, and N.
    center
        (S, 2) origin of the states [m].
    heading, order
        (S, M) candidates [rad], and their indices, the cheapest first.
    """
    found, count = np.zeros((HYPOTHESES_MAX * len(heading), STATE + STATES)), 0
    owner = np.empty(len(found), np.int64)
    starts, depth = np.empty(STARTS_MAX), np.empty((2, 2))
    for s in range(len(heading)):
        own = points[offset[s] : offset[s + 1]]
        for k in range(distinct_starts(heading[s], order[s], starts)):
            shallow_depths(own, center[s], starts[k], depth)
            for corner in range(8):
                high_0, high_1, flank = corner // 4, corner // 2 % 2, corner % 2
                if depth[0, high_0] < np.inf and depth[1, high_1] < np.inf:
                    found[count, SIDE], found[count, SIDE + 1] = 1.0 - 2.0 * high_0, 1.0 - 2.0 * high_1
                    found[count, FLANK], found[count, STATE] = flank, starts[k]
                    found[count, STATE + 1], found[count, STATE + 4] = depth[0, high_0], depth[1, high_1]
                    owner[count] = s
                    count += 1
    return found[:count], owner[:count]


@kernel(error_model="numpy")
def directions(points: Floats) -> Floats:
    """(N, 2) unit vectors from the ego to points (N, 2)."""
    ray = np.empty((len(points), 2))
    for i in range(len(points)):
        range_m = max(math.hypot(points[i, 0], points[i, 1]), 1e-6)
        ray[i, 0], ray[i, 1] = points[i, 0] / range_m, points[i, 1] / range_m
    return ray


@kernel(error_model="numpy")
def line_starts(line: Ints) -> Ints:
    """(G + 1,) first point of each of the G scan lines of points in the order of their lines `line` (N,), and N."""
    start, count = np.zeros(len(line) + 1, np.int64), 0
    for i in range(1, len(line)):
        if line[i] != line[i - 1]:
            count += 1
            start[count] = i
    start[count + 1] = len(line)
    return start[: count + 2]


@kernel(error_model="numpy")
def fit_bodies(
    points: Floats,
    line: Ints,
    offset: Ints,
    center: Floats,
    found: Floats,
    owner: Ints,
    schedule: Schedule,
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
            int(found[h, FLANK]), schedule, shape, triangle[h],
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

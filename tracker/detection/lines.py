"""Lines of T-linkage's clusters, for the variants `lines` and `paper`: which clusters are lines, and their points."""

import math
from typing import NamedTuple

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel

MINIMAL_SAMPLE = 2
"""Points that define a line."""
LENGTH_MIN_M = 0.5
"""Minimum length of a further line [m]: a motorcycle is 0.7 wide, a mirror 0.25."""
TURN_MIN = math.sin(math.radians(20.0))
"""Sine of the minimum angle between a further line and each larger one."""


class LineLimits(NamedTuple):
    """Conditions for points to form a line."""

    tau: float
    """Inlier threshold [m]."""
    length_min: float = LENGTH_MIN_M
    turn_min: float = TURN_MIN


@kernel()
def label_lines(
    points: Floats, offset: Ints, sample: Floats, first: Ints, cluster: Ints, limits: LineLimits, paper: bool
) -> tuple[Ints, Floats]:
    """Return the line (N,) of each point, 0 for the dominant one, -1 for outliers, and dominant headings (S,) [rad].

    Parameters
    ----------
    points, offset
        (N, 2) grouped by segment [m]; (S + 1,) first point of each segment, and N.
    sample, first, cluster
        (K, 2) those that were linked, by segment; first one of each segment (S + 1,); cluster of each (K,).
    paper
        True for the clusters before the largest jump in size, False for those unlikely to arise by chance.
    """
    label, heading = np.empty(len(points), np.int64), np.empty(len(offset) - 1)
    for s in range(len(heading)):
        own, drawn = points[offset[s] : offset[s + 1]], sample[first[s] : first[s + 1]]
        names = cluster[first[s] : first[s + 1]]
        found = largest_clusters(drawn, names) if paper else find_lines(own, drawn, names, limits)
        member = settle(own, found, limits.tau)
        dominant = fit_line(own, member, 0)
        heading[s] = elementary.atan2(-dominant[0], dominant[1])
        label[offset[s] : offset[s + 1]] = member
    return label, heading


@kernel(error_model="numpy")
def fit_line(points: Floats, member: Ints, name: int) -> Floats:
    """Total least squares line (3,) through the points, at least one, whose `member` is `name`."""
    count, x, y = 0, 0.0, 0.0
    for i in range(len(points)):
        if member[i] == name:
            count, x, y = count + 1, x + points[i, 0], y + points[i, 1]
    x, y = x / count, y / count
    xx, xy, yy = 0.0, 0.0, 0.0
    for i in range(len(points)):
        if member[i] == name:
            dx, dy = points[i, 0] - x, points[i, 1] - y
            xx, xy, yy = xx + dx * dx, xy + dx * dy, yy + dy * dy
    direction = 0.5 * elementary.atan2(2.0 * xy, xx - yy)
    a, b = -elementary.sin(direction), elementary.cos(direction)
    return np.array([a, b, -a * x - b * y])


@kernel()
def log_chance(count: int, support: int, share: float) -> float:
    """Logarithm of the expected number of lines near `support` of `count` scattered points by chance.

    Every pair of points is a line; other points are near it with probability `share`:
    C(count, 2) * P(Binomial(count - 2, share) >= support - 2).
    """
    pairs = elementary.log(0.5 * count * (count - 1))
    trials, hits = count - MINIMAL_SAMPLE, support - MINIMAL_SAMPLE
    if hits <= trials * share:
        return pairs
    term = elementary.log_factorial(trials) - elementary.log_factorial(hits)
    term -= elementary.log_factorial(trials - hits)
    term += hits * elementary.log(share) + (trials - hits) * elementary.log1p(-share)
    total, ratio = 1.0, 1.0
    for j in range(hits, trials):
        ratio *= (trials - j) / (j + 1) * share / (1.0 - share)
        total += ratio
    return pairs + term + elementary.log(total)


@kernel()
def near(points: Floats, line: Floats, tau: float, taken: Ints) -> Ints:
    """1 for points within tau of the line that are not taken, else 0."""
    member = np.zeros(len(points), np.int64)
    for i in range(len(points)):
        if taken[i] == 0 and abs(line[0] * points[i, 0] + line[1] * points[i, 1] + line[2]) < tau:
            member[i] = 1
    return member


@kernel()
def extent(points: Floats, line: Floats, member: Ints) -> tuple[float, float]:
    """Length and width of the box around the members, along and across the line."""
    low_t, high_t, low_d, high_d = np.inf, -np.inf, np.inf, -np.inf
    for i in range(len(points)):
        if member[i] == 1:
            t = line[1] * points[i, 0] - line[0] * points[i, 1]
            d = line[0] * points[i, 0] + line[1] * points[i, 1]
            low_t, high_t, low_d, high_d = min(low_t, t), max(high_t, t), min(low_d, d), max(high_d, d)
    return high_t - low_t, high_d - low_d


@kernel()
def find_lines(points: Floats, sample: Floats, cluster: Ints, limits: LineLimits) -> Floats:
    """Lines (L, 3), L >= 1, of the clusters of `sample` that are not outliers: the largest, and every further side."""
    tau, length_min, turn_min = limits
    size = np.bincount(cluster, minlength=len(sample))
    lines, taken, share = np.empty((0, 3)), np.zeros(len(points), np.int64), 1.0
    for name in np.argsort(-size, kind="mergesort"):
        if len(lines) > 0 and size[name] <= MINIMAL_SAMPLE:
            break
        line = fit_line(sample, cluster, name)
        member = near(points, line, tau, taken)
        line = fit_line(points, member, 1) if member.sum() > MINIMAL_SAMPLE else line
        member = near(points, line, tau, taken)
        if len(lines) == 0:
            length, width = extent(points, line, np.ones(len(points), np.int64))
            share = min(
                0.999, 2.0 * tau * elementary.hypot(length, width) / ((length + 2.0 * tau) * (width + 2.0 * tau))
            )
        elif (
            member.sum() <= MINIMAL_SAMPLE
            or np.any(np.abs(lines[:, 0] * line[1] - lines[:, 1] * line[0]) < turn_min)
            or extent(points, line, member)[0] < length_min
            or log_chance(len(points) - taken.sum(), member.sum(), share) > 0.0
        ):
            continue
        lines = np.concatenate((lines, line.reshape(1, 3)))
        taken += member
    return lines


@kernel()
def assign(points: Floats, lines: Floats, tau: float) -> Ints:
    """Nearest line within tau of each point, or -1."""
    label = np.full(len(points), -1, np.int64)
    for i in range(len(points)):
        closest = tau
        for k in range(len(lines)):
            distance = abs(lines[k, 0] * points[i, 0] + lines[k, 1] * points[i, 1] + lines[k, 2])
            if distance < closest:
                closest, label[i] = distance, k
    return label


@kernel()
def settle(points: Floats, lines: Floats, tau: float) -> Ints:
    """Refine lines and return the line (N,) of each point: 0 for the largest, -1 for none."""
    label = assign(points, lines, tau)
    for k in range(len(lines)):
        if np.sum(label == k) > MINIMAL_SAMPLE:
            lines[k] = fit_line(points, label, k)
    label = assign(points, lines, tau)
    size = np.array([np.sum(label == k) for k in range(len(lines))])
    rank = np.full(len(lines), -1, np.int64)
    for place, k in enumerate(np.argsort(-size, kind="mergesort")):
        if place == 0 or size[k] > MINIMAL_SAMPLE:
            rank[k] = place
    for i in range(len(points)):
        if label[i] >= 0:
            label[i] = rank[label[i]]
    return label


@kernel()
def largest_clusters(sample: Floats, cluster: Ints) -> Floats:
    """Lines (L, 3), L >= 1, of the clusters before the largest jump in size (Magri and Fusiello's rule for outliers).

    A cluster of a minimal sample is added, so that there is a jump after a single line.
    """
    size = np.bincount(cluster, minlength=len(sample))
    order = np.argsort(-size, kind="mergesort")
    ranked = np.append(size[order], 0)
    kept, jump = 1, -1
    for k in range(len(sample)):
        below = max(ranked[k + 1], MINIMAL_SAMPLE)
        if ranked[k] - below > jump:
            kept, jump = k + 1, ranked[k] - below
    lines = np.empty((kept, 3))
    for k in range(kept):
        lines[k] = fit_line(sample, cluster, order[k])
    return lines

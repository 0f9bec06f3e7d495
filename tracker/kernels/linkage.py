"""Hot loops of T-linkage."""

import math

import numpy as np
from numba import njit

from tracker.records import Floats, Ints

MINIMAL_SAMPLE = 2
"""Points that define a line."""


@njit(cache=True)
def hypotheses(points: Floats, uniforms: Floats, locality: float) -> Floats:
    """Lines (M, 3) through pairs of points: unit normal and offset, so that |line . (x, y, 1)| is a distance.

    Every point in turn is paired with K others (uniforms is (>= N, K)), near ones first:
    p ~ exp(-d^2 / reach^2) with reach = locality * (diagonal of the bounding box).
    A point without another place in reach gives lines infinitely far from everything.
    """
    count, repeats = len(points), uniforms.shape[1]
    reach = locality * math.hypot(np.ptp(points[:, 0]), np.ptp(points[:, 1]))
    lines = np.zeros((count * repeats, 3))
    lines[:, 2] = np.inf
    cumulative = np.empty(count)
    for i in range(count):
        total = 0.0
        for j in range(count):
            dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            squared = dx * dx + dy * dy
            total += math.exp(-squared / (reach * reach)) if squared > 0.0 else 0.0
            cumulative[j] = total
        if total == 0.0:
            continue
        for k in range(repeats):
            j = np.searchsorted(cumulative, uniforms[i, k] * total, side="right")
            dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            length = math.hypot(dx, dy)
            lines[k * count + i, 0] = -dy / length
            lines[k * count + i, 1] = dx / length
            lines[k * count + i, 2] = (dy * points[i, 0] - dx * points[i, 1]) / length
    return lines


@njit(cache=True)
def preferences(points: Floats, lines: Floats, tau: float) -> Floats:
    """Preference of every point for every line, equation (1): (M, N), a point's preferences down a column."""
    table = np.zeros((len(lines), len(points)))
    for h in range(len(lines)):
        a, b, c = lines[h]
        for i in range(len(points)):
            distance = abs(a * points[i, 0] + b * points[i, 1] + c)
            if distance < tau:
                table[h, i] = math.exp(-distance / tau)
    return table


@njit(cache=True)
def products(table: Floats, i: int, stop: int, out: Floats) -> None:
    """Inner products of column i with the first `stop` columns, into `out`."""
    out[:] = 0.0
    for h in range(table.shape[0]):
        weight = table[h, i]
        if weight > 0.0:
            for j in range(stop):
                out[j] += weight * table[h, j]


@njit(cache=True)
def tanimoto(product: float, norm_p: float, norm_q: float) -> float:
    """Tanimoto distance, equation (2), from <p, q>, |p|^2 and |q|^2; 1 where nothing is preferred."""
    return 1.0 - product / (norm_p + norm_q - product) if product > 0.0 else 1.0


@njit(cache=True)
def nearest(distance: Floats, i: int) -> int:
    """Column of the smallest distance in row i, the first of equals, i itself left out."""
    best = 1 if i == 0 else 0
    for j in range(len(distance)):
        if j != i and distance[i, j] < distance[i, best]:
            best = j
    return best


@njit(cache=True)
def merge(table: Floats, distance: Floats, norm: Floats, p: int, q: int, row: Floats) -> None:
    """Let cluster q go up in p: elementwise minimum of their preferences, distances of p anew, q at 1 from all."""
    for h in range(table.shape[0]):
        if table[h, q] < table[h, p]:
            table[h, p] = table[h, q]
        table[h, q] = 0.0
    products(table, p, len(row), row)
    norm[p], norm[q] = row[p], 0.0
    for j in range(len(row)):
        distance[p, j] = distance[j, p] = tanimoto(row[j], norm[p], norm[j])
        distance[q, j] = distance[j, q] = 1.0


@njit(cache=True)
def agglomerate(table: Floats) -> Ints:
    """Merge the nearest clusters until all are orthogonal; (N,) cluster of each point, named by a member.

    `table` (M, N) is used up. Every row remembers its nearest neighbour, so that a merge costs one row of inner
    products and not a search of the whole matrix. A distance changes only when one of its two clusters has merged, and
    that one looks for its neighbour anew: the least distance is always remembered by one of them.
    """
    count = table.shape[1]
    label = np.arange(count)
    distance, norm, row = np.ones((count, count)), np.empty(count), np.empty(count)
    for i in range(count):
        products(table, i, i + 1, row)
        norm[i] = row[i]
        for j in range(i):
            distance[i, j] = distance[j, i] = tanimoto(row[j], norm[i], norm[j])
    neighbour = np.array([nearest(distance, i) for i in range(count)]) if count > 1 else np.zeros(1, np.int64)
    while count > 1:
        p = 0
        for i in range(count):
            if distance[i, neighbour[i]] < distance[p, neighbour[p]]:
                p = i
        q = neighbour[p]
        if distance[p, q] >= 1.0:
            break
        merge(table, distance, norm, p, q, row)
        for i in range(count):
            if label[i] == q:
                label[i] = p
            if i == p or neighbour[i] == p or neighbour[i] == q:
                neighbour[i] = nearest(distance, i)
    return label


@njit(cache=True)
def fit_line(points: Floats, member: Ints, name: int) -> Floats:
    """Total least squares line (3,) through the points, one at least, whose `member` is `name`."""
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
    direction = 0.5 * math.atan2(2.0 * xy, xx - yy)
    a, b = -math.sin(direction), math.cos(direction)
    return np.array([a, b, -a * x - b * y])


@njit(cache=True)
def log_chance(count: int, support: int, share: float) -> float:
    """Log of the expected number of lines that `support` of `count` scattered points are near by chance.

    Every pair of points is a line, the others are near it with probability `share`:
    C(count, 2) * P(Binomial(count - 2, share) >= support - 2).
    """
    pairs = math.log(0.5 * count * (count - 1))
    trials, hits = count - MINIMAL_SAMPLE, support - MINIMAL_SAMPLE
    if hits <= trials * share:
        return pairs
    term = math.lgamma(trials + 1) - math.lgamma(hits + 1) - math.lgamma(trials - hits + 1)
    term += hits * math.log(share) + (trials - hits) * math.log1p(-share)
    total, ratio = 1.0, 1.0
    for j in range(hits, trials):
        ratio *= (trials - j) / (j + 1) * share / (1.0 - share)
        total += ratio
    return pairs + term + math.log(total)


@njit(cache=True)
def near(points: Floats, line: Floats, tau: float, taken: Ints) -> Ints:
    """1 for points within tau of the line that are not taken, else 0."""
    member = np.zeros(len(points), np.int64)
    for i in range(len(points)):
        if taken[i] == 0 and abs(line[0] * points[i, 0] + line[1] * points[i, 1] + line[2]) < tau:
            member[i] = 1
    return member


@njit(cache=True)
def extent(points: Floats, line: Floats, member: Ints) -> tuple[float, float]:
    """Length and width of the box around the members, along and across the line."""
    low_t, high_t, low_d, high_d = np.inf, -np.inf, np.inf, -np.inf
    for i in range(len(points)):
        if member[i] == 1:
            t = line[1] * points[i, 0] - line[0] * points[i, 1]
            d = line[0] * points[i, 0] + line[1] * points[i, 1]
            low_t, high_t, low_d, high_d = min(low_t, t), max(high_t, t), min(low_d, d), max(high_d, d)
    return high_t - low_t, high_d - low_d


@njit(cache=True)
def find_lines(points: Floats, sample: Floats, cluster: Ints, tau: float, length_min: float, turn_min: float) -> Floats:
    """Lines (L, 3) of the clusters of `sample` that are not outliers, L >= 1: the largest, and every further side."""
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
            share = min(0.999, 2.0 * tau * math.hypot(length, width) / ((length + 2.0 * tau) * (width + 2.0 * tau)))
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


@njit(cache=True)
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


@njit(cache=True)
def settle(points: Floats, lines: Floats, tau: float) -> Ints:
    """Fit lines to the points nearest to them and assign again; (N,) line of each point, 0 the largest, -1 none."""
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


@njit(cache=True)
def add_curve(points: Floats, label: Ints, name: int, tau: float, depth_max: float, beyond_max: float) -> None:
    """Give points without a line to line `name`, if they lie a little behind it as seen from the ego.

    That is where a bulging side or a rounded corner runs, up to `beyond_max` past the ends of the line.
    """
    line, low, high = fit_line(points, label, name), np.inf, -np.inf
    place = line[1] * points[:, 0] - line[0] * points[:, 1]
    for i in range(len(points)):
        if label[i] == name:
            low, high = min(low, place[i]), max(high, place[i])
    away = -1.0 if line[2] > 0.0 else 1.0
    for i in range(len(points)):
        depth = away * (line[0] * points[i, 0] + line[1] * points[i, 1] + line[2])
        beyond = max(low - place[i], place[i] - high)
        if label[i] < 0 and -tau < depth < depth_max and beyond < beyond_max:
            label[i] = name


@njit(cache=True)
def link_segments(
    points: Floats,
    offset: Ints,
    uniforms: Floats,
    tau: float,
    locality: float,
    length_min: float,
    turn_min: float,
    depth_max: float,
    beyond_max: float,
) -> tuple[Ints, Floats]:
    """Algorithm 1 on every segment: (N,) line of each point, 0 the dominant one and -1 none; (S,) its direction."""
    label, heading = np.empty(len(points), np.int64), np.empty(len(offset) - 1)
    for s in range(len(offset) - 1):
        segment = points[offset[s] : offset[s + 1]]
        kept = min(len(segment), len(uniforms))
        sample = np.empty((kept, 2))
        for i in range(kept):
            sample[i] = segment[i * len(segment) // kept]
        table = preferences(sample, hypotheses(sample, uniforms, locality), tau)
        lines = find_lines(segment, sample, agglomerate(table), tau, length_min, turn_min)
        member = settle(segment, lines, tau)
        dominant = fit_line(segment, member, 0)
        heading[s] = math.atan2(-dominant[0], dominant[1])
        for k in range(member.max() + 1):
            add_curve(segment, member, k, tau, depth_max, beyond_max)
        label[offset[s] : offset[s + 1]] = member
    return label, heading

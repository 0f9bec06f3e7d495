"""T-linkage (algorithm 1): lines, outliers and dominant direction of each segment."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.bounds import require_within
from luxloop.tracker.detection.faces import label_faces
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.lines import LineLimits, label_lines
from luxloop.tracker.detection.point_groups import even_subset
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import Linkage, SegmentedPoints

LOCALITY = 0.25
"""Largest distance of two points on a hypothesis, as a fraction of the segment's diagonal: the scale of the local
sampling in the code of Magri and Fusiello."""


@dataclass(frozen=True, slots=True)
class LinkageConfig:
    """Scale and sampling of the linkage."""

    variant: Literal["faces", "lines", "paper"] = "faces"
    """Use of T-linkage's clusters. `paper`: clusters before the largest jump in size are lines, all other points
    outliers. `lines`: clusters unlikely to arise by chance are lines, at any angle. `faces`: clusters propose the two
    perpendicular faces of a vehicle; points outside these or well inside are outliers. Change it to
    compare with the paper."""
    tau_m: float = 0.08
    """Inlier threshold of equation (1) [m]: two steps of the LUX's distance resolution, 4 cm by its data sheet.
    Change it with the noise of the unit."""
    points_max: int = 40
    """Larger segments are linked on an evenly spaced subset; every point is then assigned to the lines found.
    Change it to trade time for lines of few points."""

    def __post_init__(self) -> None:
        if self.tau_m <= 0.0:
            raise ValueError(f"tau_m is {self.tau_m}; give a positive distance in metres")
        require_within(self, 2, 10_000, "points_max")


def link(points: SegmentedPoints, config: LinkageConfig, lidar: LidarConfig) -> Linkage:
    """Run algorithm 1 on every segment.

    The hypotheses are the lines through all pairs of near points, so that results depend on no draw. Clusters with
    overlapping preferences (1) are merged, nearest first by the Tanimoto distance (2), until all are orthogonal.

    `faces` takes the line of every cluster as a side of a rectangle, single or with a perpendicular side, and keeps the
    rectangle that explains most points: points on a side count for it, points outside or well inside against it. Its
    heading is fitted to both sides at once, with the noise of each point along its beam. Line 0 is the side with more
    information on the heading, 1 the other; points along unseen sides have higher numbers. `lines` accepts, after the
    largest cluster, each one that is long enough, turned against the larger ones, and has more unexplained points than
    expected by chance: fewer than one such line among as many scattered points (Desolneux, Moisan and Morel 2000). With
    `lines` and `paper` the line of the most points is the dominant one, fitted by total least squares.
    """
    chosen, first = even_subset(points.xy, points.offset, config.points_max)
    sample = points.xy[chosen]
    cluster = link_samples(sample, first, LOCALITY, config.tau_m)
    if config.variant == "faces":
        label, heading = label_faces(points, chosen, first, cluster, config.tau_m, lidar)
    else:
        paper = config.variant == "paper"
        label, heading = label_lines(points.xy, points.offset, sample, first, cluster, LineLimits(config.tau_m), paper)
    line = np.full(len(points.segments.label), -1, dtype=np.int64)
    line[points.source] = label
    return Linkage(line=line, heading=fold(heading))


@kernel()
def hypotheses(points: Floats, locality: float) -> Floats:
    """Lines (M, 3) through all pairs of points nearer than locality * (diagonal of the bounding box).

    A line is a unit normal and an offset, so that |line . (x, y, 1)| is a distance.
    """
    reach, count = locality * diagonal(points), 0
    lines = np.empty((len(points) * (len(points) - 1) // 2, 3))
    for i in range(len(points)):
        for j in range(i):
            dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            length = math.sqrt(dx * dx + dy * dy)
            if 0.0 < length < reach:
                lines[count, 0], lines[count, 1] = -dy / length, dx / length
                lines[count, 2] = (dy * points[i, 0] - dx * points[i, 1]) / length
                count += 1
    return lines[:count]


@kernel()
def diagonal(points: Floats) -> float:
    """Return the length of the diagonal of the box around points (N, 2 or more) [m]."""
    low_x, low_y, high_x, high_y = np.inf, np.inf, -np.inf, -np.inf
    for i in range(len(points)):
        low_x, high_x = min(low_x, points[i, 0]), max(high_x, points[i, 0])
        low_y, high_y = min(low_y, points[i, 1]), max(high_y, points[i, 1])
    return elementary.hypot(high_x - low_x, high_y - low_y)


@kernel()
def preferences(points: Floats, lines: Floats, tau: float) -> Floats:
    """(M, N) preference of every point for every line, equation (1); a column contains the preferences of a point."""
    table = np.zeros((len(lines), len(points)))
    distance, near = np.empty(len(points)), np.empty(len(points) + 1, np.int64)
    for h in range(len(lines)):
        a, b, c, count = lines[h, 0], lines[h, 1], lines[h, 2], 0
        for i in range(len(points)):  # no branch: which points are near is hard to predict
            distance[i] = abs(a * points[i, 0] + b * points[i, 1] + c)
            near[count] = i
            count += distance[i] < tau
        for k in range(count):
            table[h, near[k]] = elementary.exp(-distance[near[k]] / tau)
    return table


@kernel()
def products(table: Floats, i: int, stop: int, used: Ints, out: Floats) -> None:
    """Write the inner products of column i with the first `stop` columns to `out`.

    Four lines are added at once, in their order: a loop for each would take longer to start than to add. `used` is a
    work array (>= M + 3,).
    """
    out[:], count = 0.0, 0
    for h in range(table.shape[0]):
        used[count] = h
        count += table[h, i] > 0.0
    for h in range(count, count + 3):
        used[h] = -1
    for first in range(0, count, 4):
        a, b, c, d = used[first], used[first + 1], used[first + 2], used[first + 3]
        at_a, at_b = table[a, i], table[b, i] if b >= 0 else 0.0
        at_c, at_d = table[c, i] if c >= 0 else 0.0, table[d, i] if d >= 0 else 0.0
        for j in range(stop):
            out[j] = out[j] + at_a * table[a, j] + at_b * table[b, j] + at_c * table[c, j] + at_d * table[d, j]


@kernel(error_model="numpy")
def tanimoto(product: float, norm_p: float, norm_q: float) -> float:
    """Tanimoto distance, equation (2), from <p, q>, |p|^2 and |q|^2; 1 without common preferences."""
    return 1.0 - product / (norm_p + norm_q - product) if product > 0.0 else 1.0


@kernel()
def nearest(distance: Floats, i: int) -> int:
    """Column of the smallest distance in row i, the first of equals; that of i to itself is infinite.

    The least of four distances at a time is kept, without branches: which is less is hard to predict.
    """
    row = distance[i]
    a, b, c, d = row[0], row[1], row[2], row[3]
    for j in range(4, len(row), 4):
        a, b, c, d = min(a, row[j]), min(b, row[j + 1]), min(c, row[j + 2]), min(d, row[j + 3])
    least, best = min(min(a, b), min(c, d)), 0
    while row[best] > least:
        best += 1
    return best


@kernel(error_model="numpy")
def merge(table: Floats, distance: Floats, norm: Floats, p: int, q: int, alive: Ints, used: Ints, row: Floats) -> None:
    """Merge cluster q into p: elementwise minimum of preferences, new distances of p, distance 1 from q to all.

    `alive` are the clusters; `used` and `row` are work arrays.
    """
    for h in range(table.shape[0]):
        table[h, p], table[h, q] = min(table[h, p], table[h, q]), 0.0
    products(table, p, len(row), used, row)
    norm[p], norm[q] = row[p], 0.0
    for j in alive:
        distance[p, j] = distance[j, p] = tanimoto(row[j], norm[p], norm[j])
        distance[q, j] = distance[j, q] = 1.0
    distance[p, p] = np.inf


@kernel()
def without(alive: Ints, count: int, q: int) -> int:
    """Remove q from the first sorted names of clusters, in place, and return the number of the rest."""
    kept = 0
    for k in range(count):
        if alive[k] != q:
            alive[kept] = alive[k]
            kept += 1
    return kept


@kernel(error_model="numpy")
def agglomerate(table: Floats) -> Ints:
    """Merge the nearest clusters until all are orthogonal; (N,) cluster of each point, as the index of a member.

    `table` (M, N) is overwritten. The nearest neighbour of every row is cached, so that a merge costs one row of inner
    products and not a search of the whole matrix. A distance changes only when one of its two clusters was merged, and
    that cluster searches its neighbour again, so the least distance is always in the cache of one of them.
    """
    count = table.shape[1]
    label, alive = np.arange(count), np.arange(count)
    distance, norm, row = np.ones((count, (count + 3) // 4 * 4)), np.empty(count), np.empty(count)
    used = np.empty(table.shape[0] + 3, np.int64)
    for i in range(count):
        products(table, i, i + 1, used, row)
        norm[i], distance[i, i] = row[i], np.inf
        for j in range(i):
            distance[i, j] = distance[j, i] = tanimoto(row[j], norm[i], norm[j])
    neighbour, least = np.zeros(count, np.int64), np.ones(count)
    for i in range(count if count > 1 else 0):
        neighbour[i] = nearest(distance, i)
        least[i] = distance[i, neighbour[i]]
    rest = count
    while count > 1:
        p = alive[0]
        lowest = least[p]
        for k in range(rest):
            if least[alive[k]] < lowest:
                p, lowest = alive[k], least[alive[k]]
        q = neighbour[p]
        if lowest >= 1.0:
            break
        merge(table, distance, norm, p, q, alive[:rest], used, row)
        rest, least[q] = without(alive, rest, q), 1.0
        for k in range(rest):
            c = alive[k]
            if c == p or neighbour[c] == p or neighbour[c] == q:
                neighbour[c] = nearest(distance, c)
                least[c] = distance[c, neighbour[c]]
        for i in range(count):
            label[i] = p if label[i] == q else label[i]
    return label


@kernel()
def link_samples(sample: Floats, first: Ints, locality: float, tau: float) -> Ints:
    """(K,) cluster of each point of samples (K, 2 or more), as the index of a member within its segment.

    Segment s has points first[s] to first[s + 1].
    """
    cluster = np.empty(len(sample), np.int64)
    for s in range(len(first) - 1):
        own = sample[first[s] : first[s + 1]]
        lines = hypotheses(own, locality)
        label = agglomerate(preferences(own, lines, tau))
        for i in range(len(label)):
            cluster[first[s] + i] = label[i]
    return cluster

"""Baselines: other heading estimators, for comparison only; they are never selected.

Each is a function from points (N, 2) of a segment in the ego frame [m], at two places at least, to a heading modulo 90
degrees [rad].
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.tracker.detection.lines import MINIMAL_SAMPLE, fit_line
from luxloop.tracker.detection.rectangles import measure
from luxloop.tracker.detection.tlinkage import LOCALITY, agglomerate, hypotheses
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import BASELINES, Candidates, Linkage, SegmentedPoints

INLIER_M = 0.08
"""Inlier threshold of RANSAC and J-linkage [m]: tau of T-linkage."""
POINTS_MAX = 100
"""Larger segments are reduced to an even subset: the time of J-linkage grows with the cube of the points."""
SEED = 0
"""Seed of the random samples, the same for every segment, so that segments do not affect each other."""
RANSAC_LINES = 2
"""Number of lines: at most two sides of a vehicle are visible at once."""
RANSAC_TRIALS = 100
"""Samples per line. At least one is on a side with a quarter of the points with probability
1 - (1 - 1/16)^100 = 99.8 %."""
AUTOWARE_ANGLES = np.deg2rad(np.arange(90.0))
AUTOWARE_FLOOR_M, AUTOWARE_DEPTH_MAX_M = 0.1, 0.4
"""Lower limit of a distance, and maximum depth of a point that counts, which excludes rear windows and mirrors."""


@dataclass(frozen=True, slots=True)
class BaselineConfig:
    """Switch of the baselines."""

    enabled: bool = False
    """Fit the baselines, to be graded beside the tracker's own methods; they are never selected. Set it to compare
    fits; tracks do not change."""


def append(
    points: SegmentedPoints, linkage: Linkage, candidates: Candidates, config: BaselineConfig, range_std_m: float
) -> Candidates:
    """Return the candidates with the columns of `BASELINES` appended.

    The heading of a baseline uses all points of a segment; its sides are measured on the points on lines, as those of
    the other methods, with a range noise `range_std_m` [m]. It has no cost and is not selected. Columns are NaN if not
    fitted.
    """
    shape = (points.segments.count, len(BASELINES))
    heading, center, size = np.full(shape, np.nan), np.full((*shape, 2), np.nan), np.full((*shape, 2), np.nan)
    if config.enabled and points.segments.count:
        heading = fold(np.array([headings(part) for part in np.split(points.xy, points.offset[1:-1])]))
        center, size = measure(points, linkage, heading, range_std_m)
    return Candidates(
        heading=np.concatenate([candidates.heading, heading], axis=1),
        center_ego=np.concatenate([candidates.center_ego, center], axis=1),
        size=np.concatenate([candidates.size, size], axis=1),
        cost=np.concatenate([candidates.cost, np.full(shape, np.nan)], axis=1),
        best=candidates.best,
        heading_variance=candidates.heading_variance,
    )


def headings(points: Floats) -> list[float]:
    """Return the heading of points (N, 2) by each baseline [rad]; 0 if all points are at one place."""
    if not np.ptp(points, axis=0).any():
        return [0.0] * len(BASELINES)
    kept = min(len(points), POINTS_MAX)
    sample = points[np.arange(kept) * len(points) // kept]
    return [HEADINGS[name](sample) for name in BASELINES]


def principal_axes(points: Floats) -> float:
    """Direction of largest spread of points (N, 2) [rad] (Zhao et al., ICRA 2009): their total least squares line.

    It is the heading if one side is visible; for two sides of similar length it is a diagonal.
    """
    x, y = (points - points.mean(axis=0)).T
    return 0.5 * elementary.atan2(2.0 * (x * y).sum(), (x * x).sum() - (y * y).sum())


def two_set_split(points: Floats) -> float:
    """Direction of the best two perpendicular lines through points (N, 2), split in two by azimuth [rad].

    The ordered two-set split of Shen, Pendleton and Ang (CIS and RAM 2015). For every split of the ordered points the
    lines n . p = c1 through the first set and m . p = c2 through the second, m being n turned by a quarter, are fitted
    together by least squares: with the scatter matrices S1 and S2 of the sets, S2 turned by a quarter, the smaller
    eigenvalue of S1 + S2 is the sum of squared residuals, and its eigenvector n. The split with the least residual is
    chosen; one set may contain all points.
    """
    ordered = points[_by_azimuth(points)] - points.mean(axis=0)
    first, second = _running_scatter(ordered), _running_scatter(ordered[::-1])[::-1]
    second = np.append(second[1:], np.zeros((1, 3)), axis=0)
    xx, xy, yy = (first + np.array([1.0, -1.0, 1.0]) * second[:, ::-1]).T
    residual = 0.5 * (xx + yy) - elementwise.hypot(0.5 * (xx - yy), xy)
    best = residual.argmin()
    return float(0.5 * elementwise.atan2(2.0 * xy[best], xx[best] - yy[best]))


def _by_azimuth(points_ego: Floats) -> Ints:
    """(N,) order of points (N, 2) by azimuth, from right to left, at any bearing from the ego."""
    x, y = points_ego.T
    middle_x, middle_y = points_ego.mean(axis=0)
    azimuth = elementwise.atan2(middle_x * y - middle_y * x, middle_x * x + middle_y * y)
    return np.argsort(azimuth, kind="stable")


def _running_scatter(points: Floats) -> Floats:
    """(N, 3) sums of xx, xy and yy of the first 1, 2, ... N points about their mean [m^2]."""
    x, y = points.T
    count = np.arange(1, len(points) + 1)
    sum_x, sum_y = np.cumsum(x), np.cumsum(y)
    return np.stack(
        [
            np.cumsum(x * x) - sum_x * sum_x / count,
            np.cumsum(x * y) - sum_x * sum_y / count,
            np.cumsum(y * y) - sum_y * sum_y / count,
        ],
        axis=1,
    )


def ransac_lines(points: Floats, seed: int = SEED) -> float:
    """Direction of the line with the most nearest points (N, 2) [rad], by sequential RANSAC (Fischler and Bolles 1981).

    Each line is fitted by least squares to its inliers, which are then removed. In the end every point is assigned to
    the nearest line, so that points at a corner are not biased to the line found first.
    """
    random = np.random.Generator(np.random.Philox(seed))
    lines, left = [], points
    for _ in range(RANSAC_LINES):
        agreeing = _consensus(left, random)
        if agreeing.sum() <= MINIMAL_SAMPLE:
            break
        lines.append(fit_line(left, agreeing.astype(np.int64), 1))
        left = left[~agreeing]
    if not lines:
        return principal_axes(points)
    distance = distances(points, np.array(lines))
    nearest = np.where(distance.min(axis=0) < INLIER_M, distance.argmin(axis=0), RANSAC_LINES)
    return principal_axes(points[nearest == np.bincount(nearest, minlength=RANSAC_LINES)[:RANSAC_LINES].argmax()])


def _consensus(points: Floats, random: np.random.Generator) -> Bools:
    """(N,) mask of the inliers of the line through two points that has most inliers."""
    if len(points) < MINIMAL_SAMPLE:
        return np.zeros(len(points), dtype=np.bool_)
    one = random.integers(len(points), size=RANSAC_TRIALS)
    other = (one + random.integers(1, len(points), size=RANSAC_TRIALS)) % len(points)
    near = distances(points, through(points[one], points[other])) < INLIER_M
    return np.asarray(near[near.sum(axis=1).argmax()])


def through(one: Floats, other: Floats) -> Floats:
    """Lines (M, 3) through pairs of points (M, 2): unit normal and offset, which is infinite for equal points."""
    along = other - one
    length = elementwise.hypot(*along.T)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.where(length > 0.0, length, 1.0)[:, None]
    offset = np.where(length > 0.0, -np.sum(normal * one, axis=1), np.inf)
    return np.column_stack([normal, offset])


def distances(points: Floats, lines: Floats) -> Floats:
    """(M, N) distance of points (N, 2) to lines (M, 3) [m]."""
    return np.abs(elementwise.product(lines[:, :2], points.T) + lines[:, 2:])


def jlinkage(points: Floats) -> float:
    """Direction of the line through the largest cluster of points (N, 2) [rad] (Toldo and Fusiello, ECCV 2008)."""
    cluster = jlinkage_clusters(points)
    return principal_axes(points[cluster == np.bincount(cluster).argmax()])


def jlinkage_clusters(points: Floats, inlier_m: float = INLIER_M) -> Ints:
    """(N,) cluster of each point, as the index of a member.

    For binary preferences the Tanimoto distance is the Jaccard distance and the elementwise minimum the intersection,
    so the merging of T-linkage is that of J-linkage.
    """
    lines = hypotheses(points, LOCALITY)
    return agglomerate((distances(points, lines) < inlier_m).astype(np.float64))


def autoware(points: Floats) -> float:
    """Heading of the rectangle whose nearest edge is closest to the points (N, 2), to one degree [rad].

    The closeness of Autoware (perception/shape_estimation, bounding_box.cpp). Three differences from Zhang 2017: the
    nearer of two edges is chosen per point and not once for all, distances are squared, and points deeper than
    `AUTOWARE_DEPTH_MAX_M` are ignored.
    """
    cos, sin = elementwise.cos(AUTOWARE_ANGLES), elementwise.sin(AUTOWARE_ANGLES)
    squared = (
        np.minimum(
            _to_edge(elementwise.product(points, [cos, sin])), _to_edge(elementwise.product(points, [-sin, cos]))
        )
        ** 2
    )
    closeness = np.where(squared <= AUTOWARE_DEPTH_MAX_M**2, 1.0 / np.maximum(squared, AUTOWARE_FLOOR_M**2), 0.0)
    return float(AUTOWARE_ANGLES[closeness.sum(axis=0).argmax()])


def _to_edge(position: Floats) -> Floats:
    """Distance of positions (N, A) along A directions to the nearer end of each direction [m]."""
    return np.asarray(np.minimum(position - position.min(axis=0), position.max(axis=0) - position))


HEADINGS: dict[str, Callable[[Floats], float]] = {
    "principal_axes": principal_axes,
    "two_set_split": two_set_split,
    "ransac_lines": ransac_lines,
    "jlinkage": jlinkage,
    "autoware": autoware,
}
"""Function of each baseline."""

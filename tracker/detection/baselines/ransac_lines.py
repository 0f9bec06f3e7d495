"""Sequential RANSAC (Fischler and Bolles 1981): the line with most inliers, then another in the remaining points."""

import numpy as np

from luxloop.tracker.arrays import Bools, Floats
from luxloop.tracker.detection.baselines.baseline_config import BaselineConfig
from luxloop.tracker.detection.baselines.principal_axes import direction
from luxloop.tracker.detection.lines import fit_line

SIDES = 2
"""Number of lines: at most two sides of a vehicle are visible at once."""
MINIMAL_SAMPLE = 2
"""Points that define a line."""
TRIALS = 100
"""Samples per line. At least one is on a side with a quarter of the points with probability
1 - (1 - 1/16)^100 = 99.8 %."""


def heading(points_ego: Floats, config: BaselineConfig) -> float:
    """Direction of the line with the most nearest points (N, 2) [rad].

    Each line is fitted by least squares to its inliers, which are then removed. In the end every point is assigned to
    the nearest line, so that points at a corner are not biased to the line found first.
    """
    random = np.random.Generator(np.random.Philox(config.seed))
    lines, left = [], points_ego
    for _ in range(SIDES):
        agreeing = consensus(left, config.inlier_m, random)
        if agreeing.sum() <= MINIMAL_SAMPLE:
            break
        lines.append(fit_line(left, agreeing.astype(np.int64), 1))
        left = left[~agreeing]
    if not lines:
        return direction(points_ego)
    distance = distances(points_ego, np.array(lines))
    nearest = np.where(distance.min(axis=0) < config.inlier_m, distance.argmin(axis=0), SIDES)
    return direction(points_ego[nearest == np.bincount(nearest, minlength=SIDES)[:SIDES].argmax()])


def consensus(points: Floats, inlier_m: float, random: np.random.Generator) -> Bools:
    """(N,) mask of the inliers of the line through two points that has most inliers."""
    if len(points) < MINIMAL_SAMPLE:
        return np.zeros(len(points), dtype=np.bool_)
    one = random.integers(len(points), size=TRIALS)
    other = (one + random.integers(1, len(points), size=TRIALS)) % len(points)
    near = distances(points, through(points[one], points[other])) < inlier_m
    return np.asarray(near[near.sum(axis=1).argmax()])


def through(one: Floats, other: Floats) -> Floats:
    """Lines (M, 3) through pairs of points (M, 2): unit normal and offset, which is infinite for equal points."""
    along = other - one
    length = np.hypot(*along.T)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.where(length > 0.0, length, 1.0)[:, None]
    offset = np.where(length > 0.0, -np.sum(normal * one, axis=1), np.inf)
    return np.column_stack([normal, offset])


def distances(points: Floats, lines: Floats) -> Floats:
    """(M, N) distance of points (N, 2) to lines (M, 3) [m]."""
    return np.abs(lines[:, :2] @ points.T + lines[:, 2:])

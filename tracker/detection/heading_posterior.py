"""Heading of each segment as the mean over all headings, weighted by their likelihood, with its variance.

The likelihood has two parts: the alignment of the points along and across the heading, and the extent of the segment
across the line of sight. A vehicle at an angle to the line of sight shows its flank, so that an end without points
beside it is seen head on; an occluder may hide the flank. Nothing is assumed about the shape of faces: real ones are
flat, bowed or arcs.
"""

import math

import numpy as np

from luxloop import elementary, elementwise
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.detection.alignment import FLATNESS_M, REACH_M, misalignment
from luxloop.tracker.detection.point_groups import even_subset, means
from luxloop.tracker.geometry import QUARTER, fold
from luxloop.tracker.records import SegmentedPoints

STEP_RAD = math.radians(1.0)
"""Step of the headings."""
POINTS_MAX = 100
"""Larger segments are reduced to an evenly spaced subset."""
POINTS_PER_OBSERVATION = 2.0
"""Points that count as one independent observation: neighbours on a scan line share the shape of the body."""
MISSING_COST_PER_M, TRUNCATED_COST_PER_M = 1.5, 0.75
"""Negative log-likelihood of a metre of vehicle across the line of sight without points [1/m], and the same of a
segment with a truncated end, which may continue behind an occluder."""
LENGTH_MIN_M, WIDTH_MIN_M = 3.6, 1.5
"""Least size of a car [m]; smaller vehicles lack the same extent at all headings."""
SHAPE_STD_RAD = math.radians(1.0)
"""Standard deviation of the heading due to the shape of faces [rad]: bows of 3 cm on flanks and 17 cm on ends."""


def average(points: SegmentedPoints) -> tuple[Floats, Floats]:
    """Return the heading (S,) of each segment modulo a quarter turn, ego frame [rad], and its variance (S,) [rad^2]."""
    viewpoint = means(points.viewpoint_ego, points.label, points.segments.count)
    chosen, offset = even_subset(points.xy, points.offset, POINTS_MAX)
    heading = np.arange(0.0, QUARTER - 0.5 * STEP_RAD, STEP_RAD)
    truncated = np.bincount(points.label, points.truncated, points.segments.count) > 0.0
    missing = np.where(truncated, TRUNCATED_COST_PER_M, MISSING_COST_PER_M)
    cost = heading_costs(points.xy[chosen], offset, viewpoint, missing, heading)
    weight = elementwise.exp(cost.min(axis=1, keepdims=True) - cost)
    weight /= weight.sum(axis=1, keepdims=True)
    turned = 4.0 * heading  # a quarter turn becomes a whole one
    mean = 0.25 * elementwise.atan2(
        elementwise.product(weight, elementwise.sin(turned)), elementwise.product(weight, elementwise.cos(turned))
    )
    apart = fold(heading - mean[:, None] + 0.5 * QUARTER) - 0.5 * QUARTER
    variance = (weight * apart**2).sum(axis=1)
    return mean, variance + SHAPE_STD_RAD**2


@kernel(error_model="numpy")
def heading_costs(points: Floats, offset: Ints, viewpoint: Floats, missing: Floats, heading: Floats) -> Floats:
    """Return the cost (S, M) of headings (M,).

    Segment s has points offset[s] to offset[s + 1] from viewpoint[s], and the cost missing[s] of extent without points
    [1/m].
    """
    cost = np.empty((len(offset) - 1, len(heading)))
    for s in range(len(cost)):
        costs(points[offset[s] : offset[s + 1]], viewpoint[s], missing[s], heading, cost[s])
    return cost


@kernel(error_model="numpy")
def costs(points: Floats, viewpoint: Floats, missing_cost: float, heading: Floats, cost: Floats) -> None:
    """Write the negative log-likelihood (M,) of headings (M,) for the points (N, 2) of a segment."""
    along, across = np.empty(len(points)), np.empty(len(points))
    x, y = points[:, 0].mean() - viewpoint[0], points[:, 1].mean() - viewpoint[1]
    range_m = max(elementary.hypot(x, y), 1e-9)
    ray = np.array([x / range_m, y / range_m])
    low, high = np.inf, -np.inf
    for i in range(len(points)):
        place = ray[0] * points[i, 1] - ray[1] * points[i, 0]
        low, high = min(low, place), max(high, place)
    for m in range(len(heading)):
        aligned = misalignment(points, heading[m], ray, REACH_M, FLATNESS_M, along, across)
        front = abs(elementary.cos(heading[m]) * ray[0] + elementary.sin(heading[m]) * ray[1])
        side = math.sqrt(max(1.0 - front * front, 0.0))
        lengthwise, crosswise = WIDTH_MIN_M * front + LENGTH_MIN_M * side, LENGTH_MIN_M * front + WIDTH_MIN_M * side
        missing = max(min(lengthwise, crosswise) - (high - low), 0.0)
        cost[m] = len(points) / POINTS_PER_OBSERVATION * aligned + missing_cost * missing

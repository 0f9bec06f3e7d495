"""Kernel of boxes: what the points of each box tell about its ends, its time and its viewpoint."""

import math
from typing import NamedTuple

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.compiled import kernel


class BoxPoints(NamedTuple):
    """Summary of the points of B boxes."""

    support: Ints
    """(B,) points on the fitted lines."""
    time: Floats
    """(B,) mean time of these [s]; 0 without any."""
    cut: Bools
    """(B, 2, 2) mask of ends, low and high, along and across heading, with a truncated one of these points."""
    mean: Floats
    """(B, 2) mean of all points [m]."""
    viewpoint: Floats
    """(B, 2) mean position of the units of all points [m]."""
    extent: Floats
    """(B, 2) extent of all points along and across heading [m]."""


@kernel(error_model="numpy")
def box_points(
    points: Floats,
    on_line: Bools,
    truncated: Bools,
    time: Floats,
    viewpoint: Floats,
    order: Ints,
    start: Ints,
    center: Floats,
    heading: Floats,
    size: Floats,
    cut_margin: float,
) -> BoxPoints:
    """Summarise the points of B boxes.

    Parameters
    ----------
    points, viewpoint
        (N, 2) and (N, 2), ego frame [m].
    on_line, truncated
        (N,) masks of points on fitted lines, and at truncated ends.
    time
        (N,) [s].
    order, start
        Box b has the points order[start[b, 0]] to order[start[b, 1]], at least one.
    center, heading, size
        (B, 2) [m], (B,) [rad] and (B, 2) [m].
    cut_margin
        Maximum distance of a truncated point from its end [m].
    """
    boxes = len(center)
    support, mean_time, cut = np.zeros(boxes, np.int64), np.zeros(boxes), np.zeros((boxes, 2, 2), np.bool_)
    mean, view, extent = np.zeros((boxes, 2)), np.zeros((boxes, 2)), np.zeros((boxes, 2))
    low, high = np.empty(2), np.empty(2)
    for b in range(boxes):
        cos, sin = math.cos(heading[b]), math.sin(heading[b])
        low[:], high[:] = np.inf, -np.inf
        for k in range(start[b, 0], start[b, 1]):
            i = order[k]
            x, y = points[i, 0] - center[b, 0], points[i, 1] - center[b, 1]
            place = cos * x + sin * y, cos * y - sin * x
            if on_line[i]:
                support[b] += 1
                mean_time[b] += time[i]
            for axis in range(2):
                low[axis], high[axis] = min(low[axis], place[axis]), max(high[axis], place[axis])
                mean[b, axis] += points[i, axis]
                view[b, axis] += viewpoint[i, axis]
                end = 0.5 * size[b, axis] - cut_margin
                if on_line[i] and truncated[i]:
                    cut[b, axis, 0] = cut[b, axis, 0] or -place[axis] >= end
                    cut[b, axis, 1] = cut[b, axis, 1] or place[axis] >= end
        count = start[b, 1] - start[b, 0]
        for axis in range(2):  # a loop: expressions of arrays take seconds to compile
            mean[b, axis], view[b, axis] = mean[b, axis] / count, view[b, axis] / count
            extent[b, axis] = high[axis] - low[axis]
        mean_time[b] /= max(support[b], 1)
    return BoxPoints(support, mean_time, cut, mean, view, extent)

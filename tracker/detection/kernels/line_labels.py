"""Kernel of the lines of all segments of a scan, for the variants without faces."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.lines import find_lines, fit_line, largest_clusters, settle


@kernel()
def label_lines(
    points: Floats, offset: Ints, sample: Floats, first: Ints, cluster: Ints, tau: float, length_min: float,
    turn_min: float, paper: bool,
) -> tuple[Ints, Floats]:  # fmt: skip
    """Return the line (N,) of each point, 0 for the dominant one, -1 for outliers, and dominant headings (S,) [rad].

    Parameters
    ----------
    points, offset
        (N, 3) grouped by segment [m]; (S + 1,) first point of each segment, and N.
    sample, first, cluster
        (K, 3) those that were linked, by segment; first one of each segment (S + 1,); cluster of each (K,).
    tau, length_min, turn_min
        Inlier threshold, minimum length of a further line [m], and sine of the minimum angle between two lines.
    paper
        True for the clusters before the largest jump in size, False for those unlikely to arise by chance.
    """
    label, heading = np.empty(len(points), np.int64), np.empty(len(offset) - 1)
    for s in range(len(heading)):
        own, drawn = points[offset[s] : offset[s + 1]], sample[first[s] : first[s + 1]]
        names = cluster[first[s] : first[s + 1]]
        found = largest_clusters(drawn, names) if paper else find_lines(own, drawn, names, tau, length_min, turn_min)
        member = settle(own, found, tau)
        dominant = fit_line(own, member, 0)
        heading[s] = math.atan2(-dominant[0], dominant[1])
        label[offset[s] : offset[s + 1]] = member
    return label, heading

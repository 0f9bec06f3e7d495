"""T-linkage (algorithm 1) of all segments of a scan."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.corners import best_corner
from tracker.detection.kernels.faces import excess, fit_corner
from tracker.detection.kernels.lines import find_lines, fit_line, largest_clusters, settle
from tracker.detection.kernels.linkage import agglomerate, hypotheses, preferences
from tracker.detection.kernels.outline import label_body

FACES, LINES, PAPER = 0, 1, 2
"""Variants of `LinkageConfig.variant`."""
SAME_BEARING = 1e-9
"""Weight of the range in the order of points, far below the angle between beams [rad/m]."""


class LineLimits(NamedTuple):
    """Limits of the clustering and of lines."""

    tau: float
    """Inlier threshold of equation (1) [m]."""
    locality: float
    """Reach of the local sampling, as a share of the segment's diagonal."""
    length_min: float
    """Minimum length of a further line [m]."""
    turn_min: float
    """Sine of the minimum angle between two lines."""


class FaceLimits(NamedTuple):
    """Limits of the faces of a vehicle, for the variant `FACES`."""

    noise: Floats
    """(2,) standard deviations of ranges and of the flatness of a face [m]."""
    gate: float
    """Gate on the distance to a face, in standard deviations."""
    depth_max: float
    """Depth behind a face within which points belong to it [m]."""
    beyond_max: float
    """Distance past the ends of a face within which points belong to it [m]."""
    pitch: float
    """Angle between beams [rad]."""


@njit(cache=True)
def even_subset(points: Floats, count: int) -> Ints:
    """Return up to `count` of the points (N, 2 or more), evenly spaced along the outline that the ego sees.

    The order of the points has no effect: they are sorted by bearing from their mean, those of one bearing by range.
    """
    key, x, y = np.empty(len(points)), points[:, 0].mean(), points[:, 1].mean()
    for i in range(len(points)):
        across, ahead = x * points[i, 1] - y * points[i, 0], x * points[i, 0] + y * points[i, 1]
        key[i] = math.atan2(across, ahead) + SAME_BEARING * math.hypot(points[i, 0], points[i, 1])
    kept = min(len(points), count)
    return np.argsort(key, kind="mergesort")[np.arange(kept) * len(points) // kept]


@njit(cache=True)
def link_segments(
    points: Floats, offset: Ints, uniforms: Floats, variant: int, lines: LineLimits, faces: FaceLimits
) -> tuple[Ints, Floats]:
    """Run algorithm 1 on each of S segments.

    Parameters
    ----------
    points
        (N, 3) points, grouped by segment [m].
    offset
        (S + 1,) first point of each segment, and N.
    uniforms
        (P, K) random numbers in [0, 1): K hypotheses for each of up to P points.
    variant
        `FACES`, `LINES` or `PAPER`.

    Returns
    -------
    label
        (N,) line of each point, 0 for the dominant one, -1 for outliers.
    heading
        (S,) direction of the dominant lines [rad].
    """
    tau, length_min = lines.tau, lines.length_min
    noise, gate, depth_max, beyond_max = faces.noise, faces.gate, faces.depth_max, faces.beyond_max
    label, heading = np.empty(len(points), np.int64), np.empty(len(offset) - 1)
    for s in range(len(offset) - 1):
        segment = points[offset[s] : offset[s + 1]]
        chosen = even_subset(segment, len(uniforms))
        sample = segment[chosen, :2]
        cluster = agglomerate(preferences(sample, hypotheses(sample, uniforms, lines.locality), tau))
        if variant == FACES:
            corner = best_corner(segment, chosen, cluster, tau, noise, gate, depth_max, beyond_max, length_min)
            wide = gate * excess(segment, fit_corner(segment, corner, noise, gate)[0], noise, tau)
            corner, uncertainty = fit_corner(segment, corner, noise, wide)
            member = label_body(segment, corner, uncertainty, noise, wide, depth_max, beyond_max, faces.pitch)
            dominant = corner[0]
        else:
            found = (
                find_lines(segment, sample, cluster, tau, length_min, lines.turn_min)
                if variant == LINES
                else largest_clusters(sample, cluster)
            )
            member = settle(segment, found, tau)
            dominant = fit_line(segment, member, 0)
        heading[s] = math.atan2(-dominant[0], dominant[1])
        label[offset[s] : offset[s + 1]] = member
    return label, heading

"""Algorithm 1 on all segments of a scan, one after the other."""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.corners import best_corner
from tracker.detection.kernels.faces import excess, fit_corner
from tracker.detection.kernels.lines import find_lines, fit_line, largest_clusters, settle
from tracker.detection.kernels.linkage import agglomerate, hypotheses, preferences
from tracker.detection.kernels.outline import judge

FACES, LINES, PAPER = 0, 1, 2
"""Variants."""


@njit(cache=True)
def even_subset(points: Floats, count: int) -> Floats:
    """(min(count, N), 2) points, evenly spaced in their order."""
    kept = min(len(points), count)
    sample = np.empty((kept, 2))
    for i in range(kept):
        sample[i] = points[i * len(points) // kept, :2]
    return sample


@njit(cache=True)
def link_segments(
    points: Floats,
    offset: Ints,
    uniforms: Floats,
    variant: int,
    tau: float,
    locality: float,
    length_min: float,
    turn_min: float,
    noise: Floats,
    gate: float,
    depth_max: float,
    beyond_max: float,
    pitch: float,
) -> tuple[Ints, Floats]:
    """(N,) line of each point, 0 the dominant one and -1 none, and (S,) direction of the dominant lines [rad]."""
    label, heading = np.empty(len(points), np.int64), np.empty(len(offset) - 1)
    for s in range(len(offset) - 1):
        segment = points[offset[s] : offset[s + 1]]
        sample = even_subset(segment, len(uniforms))
        cluster = agglomerate(preferences(sample, hypotheses(sample, uniforms, locality), tau))
        if variant == FACES:
            corner = best_corner(segment, sample, cluster, tau, noise, gate, depth_max, beyond_max, length_min)
            wide = gate * excess(segment, fit_corner(segment, corner, noise, gate)[0], noise, tau)
            corner, surety = fit_corner(segment, corner, noise, wide)
            member = judge(segment, corner, surety, noise, wide, depth_max, beyond_max, pitch)
            dominant = corner[0]
        else:
            lines = (
                find_lines(segment, sample, cluster, tau, length_min, turn_min)
                if variant == LINES
                else largest_clusters(sample, cluster)
            )
            member = settle(segment, lines, tau)
            dominant = fit_line(segment, member, 0)
        heading[s] = math.atan2(-dominant[0], dominant[1])
        label[offset[s] : offset[s + 1]] = member
    return label, heading

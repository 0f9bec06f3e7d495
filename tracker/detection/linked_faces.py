"""Faces of vehicles from the clusters of T-linkage: the corner of each segment, and the points on its body."""

import math
from typing import TYPE_CHECKING

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.detection.kernels.corners import candidate_faces, scores
from luxloop.tracker.detection.kernels.faces import excesses, fit_corners
from luxloop.tracker.detection.kernels.linkage import MINIMAL_SAMPLE
from luxloop.tracker.detection.kernels.outline import label_bodies

if TYPE_CHECKING:
    from luxloop.tracker.detection.tlinkage import LinkageConfig


def label_faces(
    points: Floats, offset: Ints, chosen: Ints, first: Ints, cluster: Ints, config: "LinkageConfig"
) -> tuple[Ints, Floats]:
    """Return the face (N,) of each point, 0 for the dominant one, -1 for outliers, and dominant headings (S,) [rad].

    Parameters
    ----------
    points, offset
        (N, 3) grouped by segment [m]; (S + 1,) first point of each segment, and N.
    chosen, first, cluster
        (K,) points that were linked, by segment; first one of each segment (S + 1,); cluster of each (K,).
    """
    noise, gate = np.array([config.range_std_m, config.flatness_m]), np.full(len(offset) - 1, config.gate)
    corner = best_corners(points, offset, chosen, first, cluster, noise, config)
    fit_corners(points, offset, corner, noise, gate)
    wide = gate * excesses(points, offset, corner, noise, config.tau_m)
    uncertainty, information = fit_corners(points, offset, corner, noise, wide)
    put_dominant_first(corner, uncertainty, information)
    limits = config.curve_depth_m, config.curve_beyond_m, math.radians(config.pitch_deg)
    label: Ints
    heading: Floats
    label, heading = label_bodies(points, offset, corner, uncertainty, noise, wide, *limits)
    return label, heading


def best_corners(
    points: Floats, offset: Ints, chosen: Ints, first: Ints, cluster: Ints, noise: Floats, config: "LinkageConfig"
) -> Floats:
    """Return the corner (S, 2, 3) that explains most points, among the lines of the clusters of each segment.

    Clusters compete by all points that their rectangle explains, not by their own: a dense rounded corner makes a
    larger cluster than the sparse flank beside it, but does not explain the flank. Of equal scores the line with more
    information on the heading is chosen. The largest cluster is the result if no other is long enough.
    """
    name, owner, largest = _candidates(first, cluster)
    sample = points[chosen]
    face, length, information = candidate_faces(points, offset, sample, first, cluster, name, owner, config.tau_m)
    used = largest | (length >= config.length_min_m)
    face, owner, information = face[used], owner[used], information[used]
    limits = config.gate, config.curve_depth_m, config.curve_beyond_m, 0.5 * config.length_min_m
    score, other = scores(points, offset, chosen, first, face, owner, noise, *limits)
    order = np.lexsort((-information, -score, owner))
    best = order[np.searchsorted(owner, np.arange(len(offset) - 1))]
    return np.stack([face[best], other[best]], axis=1)


def put_dominant_first(corner: Floats, uncertainty: Floats, information: Floats) -> None:
    """Put the face with more information on the heading first, in place: a sparse flank before a dense bumper.

    `corner` and `uncertainty` are (S, 2, 3), `information` is (S, 2), as of `fit_corners`.
    """
    swapped = information[:, 1] > information[:, 0]
    corner[swapped], uncertainty[swapped] = corner[swapped, ::-1], uncertainty[swapped, ::-1]


def _candidates(first: Ints, cluster: Ints) -> tuple[Ints, Ints, Ints]:
    """Return clusters (C,) with more than a minimal sample, and each segment's largest one, the largest first.

    The other results are the segments of the clusters (C,), and the mask (C,) of the largest ones.
    """
    owner = np.repeat(np.arange(len(first) - 1), np.diff(first))
    size = np.bincount(first[owner] + cluster, minlength=len(cluster))
    order = np.lexsort((-size, owner))
    largest = np.arange(len(order)) == first[owner]
    used = largest | (size[order] > MINIMAL_SAMPLE)
    return order[used] - first[owner[used]], owner[used], largest[used]

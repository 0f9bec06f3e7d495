"""Kernels of corners: selection of a vehicle's side among the lines of T-linkage, and of a perpendicular side."""

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.faces import depths, inward
from tracker.detection.kernels.lines import extent, fit_line, near
from tracker.detection.kernels.linkage import MINIMAL_SAMPLE


@njit(cache=True)
def beside(place: Floats, member: Ints, beyond_max: float) -> Ints:
    """1 for places between the ends of the members or at most `beyond_max` past them, else 0."""
    low, high = np.inf, -np.inf
    for i in range(len(place)):
        if member[i] == 1:
            low, high = min(low, place[i]), max(high, place[i])
    return ((place > low - beyond_max) & (place < high + beyond_max)).astype(np.int64)


@njit(cache=True)
def explained(first: Floats, aside: Ints, second: Floats, gates: Floats, depth_max: float) -> int:
    """Return the points on either of two faces minus those that contradict them; depths (N,) behind each, gates (2, N).

    A body is convex: points outside a face contradict it, and so do points well inside. Points just behind a face, on
    rounded parts, do not count.
    """
    score = 0
    for i in range(len(first)):
        if first[i] < -gates[0, i] or second[i] < -gates[1, i]:
            score -= 1
        elif first[i] < gates[0, i] or second[i] < gates[1, i]:
            score += 1
        elif not (aside[i] == 1 and first[i] < depth_max) and second[i] >= depth_max:
            score -= 1
    return score


@njit(cache=True)
def across(
    points: Floats,
    chosen: Ints,
    face: Floats,
    noise: Floats,
    gate: float,
    depth_max: float,
    beyond_max: float,
    length_min: float,
) -> tuple[int, Floats]:
    """Return the score of a face, single or with the best perpendicular face (3,) at either end, and that one or zeros.

    Every `chosen` point off the face is a candidate for the other face, which has at least two points, farther apart
    than the length of a mirror. All points score.
    """
    depth, place, std = depths(points, face, noise)
    turned = np.array([face[1], -face[0], 0.0])
    gates = gate * np.stack((std, depths(points, turned, noise)[2]))
    aside = beside(place, (np.abs(depth) < gates[0]).astype(np.int64), beyond_max)
    other, best = np.zeros(3), explained(depth, aside, np.full(len(points), np.inf), gates, depth_max)
    deep = np.flatnonzero(depth > gates[0])
    shallow = len(points) - len(deep) - 2 * np.sum(depth < -gates[0])  # the score of all others
    for c in chosen:
        if depth[c] < gates[0, c]:
            continue
        nearest, farthest, count, mean = np.inf, -np.inf, 0, 0.0
        for i in deep:
            if abs(place[i] - place[c]) < gates[1, i]:
                nearest, farthest = min(nearest, depth[i]), max(farthest, depth[i])
                count, mean = count + 1, mean + place[i]
        if count < MINIMAL_SAMPLE or farthest - nearest < length_min or shallow + count <= best:
            continue
        for sign in (1.0, -1.0):
            score = explained(depth, aside, sign * (place - place[c]), gates, depth_max)
            if score > best:
                best, other = score, np.array([sign * face[1], -sign * face[0], -sign * mean / count])
    return best, other


@njit(cache=True)
def best_corner(
    points: Floats,
    chosen: Ints,
    cluster: Ints,
    tau: float,
    noise: Floats,
    gate: float,
    depth_max: float,
    beyond_max: float,
    length_min: float,
) -> Floats:
    """Return the corner (2, 3) that explains most points, among the lines of the clusters of the `chosen` ones.

    Clusters compete by all points that their rectangle explains, not by their own: a dense rounded corner makes a
    larger cluster than the sparse flank beside it, but does not explain the flank. Of equal scores the line with more
    information on the heading is chosen. The largest cluster is the result if no other is long enough.
    """
    sample = points[chosen]
    size = np.bincount(cluster, minlength=len(sample))
    corner, best, best_information, nothing = np.zeros((2, 3)), -len(points) - 1, 0.0, np.zeros(len(points), np.int64)
    for rank, name in enumerate(np.argsort(-size, kind="mergesort")):
        if rank > 0 and size[name] <= MINIMAL_SAMPLE:
            break
        line = fit_line(sample, cluster, name)
        member = near(points, line, tau, nothing)
        if member.sum() > MINIMAL_SAMPLE:
            line = fit_line(points, member, 1)
            member = near(points, line, tau, nothing)
        length = extent(points, line, member)[0]
        if rank > 0 and length < length_min:
            continue
        face = inward(points, line, tau)
        score, other = across(points, chosen, face, noise, gate, depth_max, beyond_max, 0.5 * length_min)
        information = length * length * member.sum()
        if score > best or (score == best and information > best_information):
            best, best_information = score, information
            corner[0], corner[1] = face, other
    return corner

"""Kernels of corners: a vehicle's side for each line of T-linkage, and a perpendicular side."""

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.faces import depth_std, faces_away
from luxloop.tracker.detection.kernels.groups import columns
from luxloop.tracker.detection.kernels.lines import extent, fit_line, near
from luxloop.tracker.detection.kernels.linkage import MINIMAL_SAMPLE


@kernel(error_model="numpy")
def candidate_faces(
    points: Floats, offset: Ints, sample: Floats, first: Ints, cluster: Ints, name: Ints, owner: Ints, tau: float
) -> tuple[Floats, Floats, Floats]:
    """Return face (C, 3), length (C,) [m], and information on the heading (C,) of the lines of clusters.

    Parameters
    ----------
    points, offset
        (N, 2 or 3) grouped by segment [m]; (S + 1,) first point of each segment, and N.
    sample, first, cluster
        (K, 2 or 3) those that were linked, by segment; first one of each segment (S + 1,); cluster of each (K,).
    name, owner
        (C,) clusters, and their segments.
    """
    face, length, information = np.empty((len(name), 3)), np.empty(len(name)), np.empty(len(name))
    nothing = np.zeros(len(points), np.int64)
    for c in range(len(name)):
        s = owner[c]
        own, cloud = points[offset[s] : offset[s + 1]], sample[first[s] : first[s + 1]]
        member, key, count = cluster[first[s] : first[s + 1]], name[c], 0
        for _ in range(2):  # a line through the cluster, then one through the points near it, if they are enough
            line = fit_line(cloud, member, key)
            cloud, member, key = own, near(own, line, tau, nothing), 1
            count = member.sum()
            if count <= MINIMAL_SAMPLE:
                break
        length[c] = extent(own, line, member)[0]
        information[c] = length[c] * length[c] * count
        sign = -1.0 if faces_away(own, line, tau) else 1.0
        for a in range(3):
            face[c, a] = sign * line[a]
    return face, length, information


@kernel()
def beside(depth: Floats, place: Floats, gates: Floats, beyond_max: float, aside: Ints) -> None:
    """Write 1 for places between the ends of the points on a face or at most `beyond_max` past them, else 0."""
    low, high = np.inf, -np.inf
    for i in range(len(place)):
        if abs(depth[i]) < gates[0, i]:
            low, high = min(low, place[i]), max(high, place[i])
    for i in range(len(place)):
        aside[i] = low - beyond_max < place[i] < high + beyond_max


@kernel()
def explained(
    depth: Floats, aside: Ints, place: Floats, start: float, sign: float, gates: Floats, depth_max: float
) -> int:
    """Return the points on either of two faces minus those that contradict them; gates (2, N).

    Depths (N,) are behind the first face; the second one is at place `start`, with the body in the direction `sign`
    of it. A body is convex: points outside a face contradict it, and so do points well inside. Points just behind a
    face, on rounded parts, do not count.
    """
    score = 0
    for i in range(len(depth)):  # no branch: the compiler vectorises it
        second = sign * (place[i] - start)
        outside = (depth[i] < -gates[0, i]) | (second < -gates[1, i])
        on_face = (depth[i] < gates[0, i]) | (second < gates[1, i])
        deep = (second >= depth_max) & ((aside[i] != 1) | (depth[i] >= depth_max))
        score += -1 if outside else (1 if on_face else (-1 if deep else 0))
    return score


@kernel(error_model="numpy")
def measure(
    x: Floats, y: Floats, face: Floats, noise: tuple[float, float], gate: float, depth: Floats, place: Floats,
    gates: Floats, deep: Floats,
) -> tuple[int, int]:  # fmt: skip
    """Write depth behind a face, place along it, gates of the depth behind it and behind a perpendicular one (2, N).

    Return the number of points deeper than the gate, whose depth, place and second gate are written to `deep` (3, N),
    and the number of those as far in front.
    """
    a, b, c, behind, before = face[0], face[1], face[2], 0, 0
    for i in range(len(x)):  # no branch: the compiler vectorises it
        normal, place[i] = a * x[i] + b * y[i], b * x[i] - a * y[i]
        depth[i] = normal + c
        gates[0, i] = gate * depth_std(normal, x[i], y[i], noise)
        gates[1, i] = gate * depth_std(b * x[i] - a * y[i], x[i], y[i], noise)
    for i in range(len(x)):
        before += depth[i] < -gates[0, i]
        deep[0, behind], deep[1, behind], deep[2, behind] = depth[i], place[i], gates[1, i]
        behind += depth[i] > gates[0, i]
    return behind, before


@kernel(error_model="numpy")
def across(
    x: Floats, y: Floats, chosen: Ints, face: Floats, noise: tuple[float, float], gate: float, depth_max: float,
    beyond_max: float, length_min: float, other: Floats,
) -> int:  # fmt: skip
    """Return the score of a face, single or with the best perpendicular face at either end; write that one or zeros.

    Every `chosen` point off the face is a candidate for the other face (3,), which has at least two points, farther
    apart than the length of a mirror. All points score.
    """
    count = len(x)
    depth, place, gates = np.empty(count), np.empty(count), np.empty((2, count))
    aside, deep, other[:] = np.empty(count, np.int64), np.empty((3, count)), 0.0
    behind, before = measure(x, y, face, noise, gate, depth, place, gates, deep)
    beside(depth, place, gates, beyond_max, aside)
    best = explained(depth, aside, place, -np.inf, 1.0, gates, depth_max)  # no other face: infinitely far away
    for c in chosen:
        if depth[c] < gates[0, c]:
            continue
        support, at = 0, place[c]
        for i in range(behind):  # no branch: the compiler vectorises it
            support += abs(deep[1, i] - at) < deep[2, i]
        most = count - behind - 2 * before + support  # the score if no other point contradicts
        if support < MINIMAL_SAMPLE or most <= best:
            continue
        nearest, farthest, total = np.inf, -np.inf, 0.0
        for i in range(behind):
            if abs(deep[1, i] - at) < deep[2, i]:
                nearest, farthest, total = min(nearest, deep[0, i]), max(farthest, deep[0, i]), total + deep[1, i]
        if farthest - nearest < length_min:
            continue
        for sign in (1.0, -1.0):
            score = explained(depth, aside, place, place[c], sign, gates, depth_max)
            if score > best:
                best, other[0], other[1], other[2] = score, sign * face[1], -sign * face[0], -sign * total / support
    return best


@kernel()
def scores(
    points: Floats, offset: Ints, chosen: Ints, first: Ints, face: Floats, owner: Ints, noise: Floats, gate: float,
    depth_max: float, beyond_max: float, length_min: float,
) -> tuple[Ints, Floats]:  # fmt: skip
    """Return the score (C,) of faces (C, 3) of segments `owner` (C,), and their perpendicular faces (C, 3).

    `chosen` (K,) are indices of points, and first[s] to first[s + 1] of them are in segment s; see `across`.
    """
    score, other, (x, y) = np.empty(len(face), np.int64), np.empty((len(face), 3)), columns(points)
    for c in range(len(face)):
        s = owner[c]
        own = slice(offset[s], offset[s + 1])
        score[c] = across(
            x[own], y[own], chosen[first[s] : first[s + 1]] - offset[s], face[c], (noise[0], noise[1]), gate, depth_max,
            beyond_max, length_min, other[c],
        )  # fmt: skip
    return score, other

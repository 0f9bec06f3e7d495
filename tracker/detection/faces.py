"""Faces of vehicles from the clusters of T-linkage: the corner of each segment, and the points on its body.

A face is a line (3,) whose unit normal points into the body, so that face . (x, y, 1) is a point's depth behind it.
A corner (2, 3) contains the faces of one vehicle; the second is zeros if only one is visible.
"""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.detection.lidar import LidarConfig
from luxloop.tracker.detection.lines import LENGTH_MIN_M, MINIMAL_SAMPLE, extent, fit_line, near
from luxloop.tracker.detection.point_groups import columns
from luxloop.tracker.free_space import UNIT_OFFSET_M
from luxloop.tracker.records import SegmentedPoints

FLATNESS_M = 0.01
"""Standard deviation of a vehicle's side from a plane [m]: it leans by 3 to 5 degrees above and below its widest line.
A larger deviation of the points widens the gate, because real sides are curved."""
GATE = 3.0
"""Gate on the distance of a point to a face, in standard deviations."""
CURVE_DEPTH_M = 0.24
"""Depth behind a face within which points belong to it, but not to its direction [m]: fronts and rears of real cars are
bowed by this much at hood height (median of 8), a rear window is at least 0.85 behind."""
CURVE_BEYOND_M = 0.4
"""Distance past the ends of a face for the same [m]: corners of cars are rounded over 0.2 to 0.4."""
NORMAL_MEDIAN = 0.6745
"""Median of the absolute value of a standard normal variable."""
ROUNDS = 2
"""Iterations of assigning points to faces and fitting the faces; a third one has a negligible effect."""
WIDTH_MAX = 2.8
"""Maximum width of a vehicle [m]; a longer face is a flank. Mirrors protrude from flanks only: points in front of a
front or rear are range outliers, for which the gate is doubled."""
WHOLE_MIN = 1.0
"""Minimum visible extent of a face whose ends are taken for those of the vehicle [m]."""
MIRROR_OUT = 0.35
"""Maximum protrusion of a mirror, including trucks [m]."""
MIRROR_HALF = 0.08
"""Half the extent of a mirror along the flank [m]."""
MIRROR_APART = 0.2
"""Maximum distance between points of one mirror along the flank [m]."""
MIRROR_Z_MIN = 0.75
"""Minimum height of a mirror [m]; the lower edge of a car's mirror is at 0.9."""
MIRROR_HEIGHT = 0.12
"""Maximum height difference between points of a mirror on different layers [m]."""
MIRROR_FOOT = 0.06
"""Depth of a mirror's base inside the side [m]."""
MIRROR_GATE = 4.0
"""Gate in standard deviations beyond which a point is on a mirror; near points at the same height are, too."""


def label_faces(
    points: SegmentedPoints, chosen: Ints, first: Ints, cluster: Ints, tau_m: float, lidar: LidarConfig
) -> tuple[Ints, Floats]:
    """Return the face (P,) of each point, 0 for the dominant one, -1 for outliers, and dominant headings (S,) [rad].

    Parameters
    ----------
    points
        Their height identifies points of mirrors in the plane of a side.
    chosen, first, cluster
        (K,) points that were linked, by segment; first one of each segment (S + 1,); cluster of each (K,).
    tau_m
        Inlier threshold of the linkage [m].
    """
    xy, offset, noise = points.xy, points.offset, np.array([lidar.range_std_m, FLATNESS_M])
    gate = np.full(len(offset) - 1, GATE)
    corner = best_corners(xy, offset, chosen, first, cluster, noise, tau_m)
    fit_corners(xy, offset, corner, noise, gate)
    wide = gate * excesses(xy, offset, corner, noise, tau_m)
    uncertainty, information = fit_corners(xy, offset, corner, noise, wide)
    put_dominant_first(corner, uncertainty, information)
    label: Ints
    heading: Floats
    label, heading = label_bodies(xy, points.z, offset, corner, uncertainty, noise, wide, lidar.pitch_rad)
    return label, heading


def best_corners(
    points: Floats, offset: Ints, chosen: Ints, first: Ints, cluster: Ints, noise: Floats, tau_m: float
) -> Floats:
    """Return the corner (S, 2, 3) that explains most points, among the lines of the clusters of each segment.

    Clusters compete by all points that their rectangle explains, not by their own: a dense rounded corner makes a
    larger cluster than the sparse flank beside it, but does not explain the flank. Of equal scores the line with more
    information on the heading is chosen. The largest cluster is the result if no other is long enough.
    """
    name, owner, largest = _candidates(first, cluster)
    sample = points[chosen]
    face, length, information = candidate_faces(points, offset, sample, first, cluster, name, owner, tau_m)
    used = largest | (length >= LENGTH_MIN_M)
    face, owner, information = face[used], owner[used], information[used]
    score, other = scores(points, offset, chosen, first, face, owner, noise)
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


@kernel(error_model="numpy")
def candidate_faces(
    points: Floats, offset: Ints, sample: Floats, first: Ints, cluster: Ints, name: Ints, owner: Ints, tau: float
) -> tuple[Floats, Floats, Floats]:
    """Return face (C, 3), length (C,) [m], and information on the heading (C,) of the lines of clusters.

    Parameters
    ----------
    points, offset
        (N, 2) grouped by segment [m]; (S + 1,) first point of each segment, and N.
    sample, first, cluster
        (K, 2) those that were linked, by segment; first one of each segment (S + 1,); cluster of each (K,).
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
def beside(depth: Floats, place: Floats, gates: Floats, aside: Ints) -> None:
    """Write 1 for places between the ends of the points on a face or at most `CURVE_BEYOND_M` past them, else 0."""
    low, high = np.inf, -np.inf
    for i in range(len(place)):
        if abs(depth[i]) < gates[0, i]:
            low, high = min(low, place[i]), max(high, place[i])
    for i in range(len(place)):
        aside[i] = low - CURVE_BEYOND_M < place[i] < high + CURVE_BEYOND_M


@kernel()
def explained(depth: Floats, aside: Ints, place: Floats, start: float, sign: float, gates: Floats) -> int:
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
        deep = (second >= CURVE_DEPTH_M) & ((aside[i] != 1) | (depth[i] >= CURVE_DEPTH_M))
        score += -1 if outside else (1 if on_face else (-1 if deep else 0))
    return score


@kernel(error_model="numpy")
def measure(
    x: Floats, y: Floats, face: Floats, noise: tuple[float, float], depth: Floats, place: Floats, gates: Floats,
    deep: Floats,
) -> tuple[int, int]:  # fmt: skip
    """Write depth behind a face, place along it, gates of the depth behind it and behind a perpendicular one (2, N).

    Return the number of points deeper than the gate, whose depth, place and second gate are written to `deep` (3, N),
    and the number of those as far in front.
    """
    a, b, c, behind, before = face[0], face[1], face[2], 0, 0
    for i in range(len(x)):  # no branch: the compiler vectorises it
        normal, place[i] = a * x[i] + b * y[i], b * x[i] - a * y[i]
        depth[i] = normal + c
        gates[0, i] = GATE * depth_std(normal, x[i], y[i], noise)
        gates[1, i] = GATE * depth_std(b * x[i] - a * y[i], x[i], y[i], noise)
    for i in range(len(x)):
        before += depth[i] < -gates[0, i]
        deep[0, behind], deep[1, behind], deep[2, behind] = depth[i], place[i], gates[1, i]
        behind += depth[i] > gates[0, i]
    return behind, before


@kernel(error_model="numpy")
def across(x: Floats, y: Floats, chosen: Ints, face: Floats, noise: tuple[float, float], other: Floats) -> int:
    """Return the score of a face, single or with the best perpendicular face at either end; write that one or zeros.

    Every `chosen` point off the face is a candidate for the other face (3,), which has at least two points, farther
    apart than the length of a mirror. All points score.
    """
    count = len(x)
    depth, place, gates = np.empty(count), np.empty(count), np.empty((2, count))
    aside, deep, other[:] = np.empty(count, np.int64), np.empty((3, count)), 0.0
    behind, before = measure(x, y, face, noise, depth, place, gates, deep)
    beside(depth, place, gates, aside)
    best = explained(depth, aside, place, -np.inf, 1.0, gates)  # no other face: infinitely far away
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
        if farthest - nearest < 0.5 * LENGTH_MIN_M:
            continue
        for sign in (1.0, -1.0):
            score = explained(depth, aside, place, place[c], sign, gates)
            if score > best:
                best, other[0], other[1], other[2] = score, sign * face[1], -sign * face[0], -sign * total / support
    return best


@kernel()
def scores(
    points: Floats, offset: Ints, chosen: Ints, first: Ints, face: Floats, owner: Ints, noise: Floats
) -> tuple[Ints, Floats]:
    """Return the score (C,) of faces (C, 3) of segments `owner` (C,), and their perpendicular faces (C, 3).

    `chosen` (K,) are indices of points, and first[s] to first[s + 1] of them are in segment s; see `across`.
    """
    score, other, (x, y) = np.empty(len(face), np.int64), np.empty((len(face), 3)), columns(points)
    for c in range(len(face)):
        s = owner[c]
        own = slice(offset[s], offset[s + 1])
        linked = chosen[first[s] : first[s + 1]] - offset[s]
        score[c] = across(x[own], y[own], linked, face[c], (noise[0], noise[1]), other[c])
    return score, other


@kernel()
def faces_away(points: Floats, line: Floats, tau: float) -> bool:
    """Return True if the normal of a line points out of the body.

    The ego is outside. If it is so near the line that its units may be on either side, the other points decide: more
    points of a body lie behind a face than in front of it.
    """
    side = -line[2]
    if abs(line[2]) < UNIT_OFFSET_M:
        balance = 0
        for i in range(len(points)):
            depth = line[0] * points[i, 0] + line[1] * points[i, 1] + line[2]
            if abs(depth) > tau:
                balance += 1 if depth > 0.0 else -1
        side = float(balance) if balance != 0 else side
    return bool(side <= 0.0)


@kernel()
def exists(corner: Floats, k: int) -> bool:
    """Return True if a corner (2, 3) has face k."""
    return bool(corner[k, 0] != 0.0 or corner[k, 1] != 0.0)


@kernel(error_model="numpy")
def depth_std(across: float, x: float, y: float, noise: tuple[float, float]) -> float:
    """Return the standard deviation of the depth of a point behind a face [m]; `across` is normal . (x, y).

    Range noise noise[0] is along the beam; the flatness of sides is noise[1]. At grazing incidence the range noise has
    little effect on the depth.
    """
    slant = noise[0] * across / max(math.sqrt(x * x + y * y), 1e-9)
    return math.sqrt(slant * slant + noise[1] * noise[1])


@kernel(error_model="numpy")
def nearest_face(
    x: Floats, y: Floats, corner: Floats, noise: tuple[float, float], gate: float, member: Ints, weight: Floats
) -> None:
    """Write the face (N,) of each point that lies within `gate` standard deviations of one, or -1.

    The other result is the weight (N,) of a point on a face, 1 / variance [1/m^2].
    """
    a_0, b_0, c_0, gate_0 = corner[0, 0], corner[0, 1], corner[0, 2], gate if exists(corner, 0) else 0.0
    a_1, b_1, c_1, gate_1 = corner[1, 0], corner[1, 1], corner[1, 2], gate if exists(corner, 1) else 0.0
    for i in range(len(x)):  # no branch: the compiler vectorises it
        across_0, across_1 = a_0 * x[i] + b_0 * y[i], a_1 * x[i] + b_1 * y[i]
        std_0, std_1 = depth_std(across_0, x[i], y[i], noise), depth_std(across_1, x[i], y[i], noise)
        distance_0, distance_1 = abs(across_0 + c_0), abs(across_1 + c_1)
        on_0 = distance_0 < gate_0 * std_0
        on_1 = distance_1 < (min(distance_0 / std_0, gate_1) if on_0 else gate_1) * std_1
        std = std_1 if on_1 else std_0
        member[i], weight[i] = 1 if on_1 else (0 if on_0 else -1), 1.0 / std**2


@kernel(error_model="numpy")
def moments(x: Floats, y: Floats, member: Ints, k: int, weights: Floats, moment: Floats) -> None:
    """Write total weight, mean x, mean y, and weighted sums of xx, xy and yy about the mean, of face k to row k."""
    total, mean_x, mean_y = 0.0, 0.0, 0.0
    for i in range(len(x)):
        if member[i] == k:
            weight = weights[i]
            total, mean_x, mean_y = total + weight, mean_x + weight * x[i], mean_y + weight * y[i]
    moment[k] = 0.0
    if total == 0.0:
        return
    mean_x, mean_y = mean_x / total, mean_y / total
    xx, xy, yy = 0.0, 0.0, 0.0
    for i in range(len(x)):
        if member[i] == k:
            weight, dx, dy = weights[i], x[i] - mean_x, y[i] - mean_y
            xx, xy, yy = xx + weight * dx * dx, xy + weight * dx * dy, yy + weight * dy * dy
    moment[k, 0], moment[k, 1], moment[k, 2] = total, mean_x, mean_y
    moment[k, 3], moment[k, 4], moment[k, 5] = xx, xy, yy


@kernel()
def set_face(corner: Floats, k: int, normal_angle: float, x: float, y: float) -> None:
    """Move face k of a corner through a point; turn its normal to an angle or its opposite [rad]."""
    a, b = elementary.cos(normal_angle), elementary.sin(normal_angle)
    if a * corner[k, 0] + b * corner[k, 1] < 0.0:
        a, b = -a, -b
    corner[k, 0], corner[k, 1], corner[k, 2] = a, b, -a * x - b * y


@kernel(error_model="numpy")
def fit_corner(
    x: Floats, y: Floats, corner: Floats, noise: tuple[float, float], gate: float, uncertainty: Floats,
    information: Floats,
) -> None:  # fmt: skip
    """Fit one heading and the place of each face to the points on them, by weighted total least squares, in place.

    Rotating the points of one face by a right angle adds their moments to those of the other.

    Parameters
    ----------
    corner
        (2, 3) in and out.
    uncertainty
        (2, 3) out: mean place of each face [m], variance of its depth there [m^2], and variance of the common direction
        [rad^2].
    information
        (2,) out: that of each face on the heading, sum((place - mean)^2 / variance) [1/rad^2].
    """
    moment, member, weight = np.zeros((2, 6)), np.empty(len(x), np.int64), np.empty(len(x))
    for _ in range(ROUNDS):
        nearest_face(x, y, corner, noise, gate, member, weight)
        for k in range(2):
            moments(x, y, member, k, weight, moment)
        if moment[0, 0] == 0.0:
            break
        xx, yy = moment[0, 3] + moment[1, 5], moment[0, 5] + moment[1, 3]
        direction = 0.5 * elementary.atan2(2.0 * (moment[0, 4] - moment[1, 4]), xx - yy)
        for k in range(2):
            if moment[k, 0] > 0.0:
                set_face(corner, k, direction + 0.5 * math.pi * (1 - k), moment[k, 1], moment[k, 2])
            else:
                corner[k] = 0.0
    for k in range(2):
        information[k] = moment[k, 3] + moment[k, 5]
        uncertainty[k, 0] = corner[k, 1] * moment[k, 1] - corner[k, 0] * moment[k, 2]
        uncertainty[k, 1] = 1.0 / max(moment[k, 0], 1e-9)
    for k in range(2):
        uncertainty[k, 2] = 1.0 / max(information[0] + information[1], 1e-9)


@kernel(error_model="numpy")
def fit_corners(points: Floats, offset: Ints, corner: Floats, noise: Floats, gate: Floats) -> tuple[Floats, Floats]:
    """Fit corners (S, 2, 3) in place; return their uncertainties (S, 2, 3) and information (S, 2), see `fit_corner`.

    Segment s has points offset[s] to offset[s + 1]; its faces have the points within gate[s] standard deviations.
    """
    uncertainty, information = np.empty((len(corner), 2, 3)), np.empty((len(corner), 2))
    x, y = columns(points)
    for s in range(len(corner)):
        own = slice(offset[s], offset[s + 1])
        fit_corner(x[own], y[own], corner[s], (noise[0], noise[1]), gate[s], uncertainty[s], information[s])
    return uncertainty, information


@kernel(error_model="numpy")
def excesses(points: Floats, offset: Ints, corner: Floats, noise: Floats, tau: float) -> Floats:
    """(S,) ratio of the points' deviation from the faces of their corner (S, 2, 3) to their noise, at least 1.

    Based on the median of |depth| / std of the points within tau of a face, which is 0.67 for normal noise. Real sides
    are curved.
    """
    excess, ratio = np.ones(len(corner)), np.empty(len(points))
    for s in range(len(corner)):
        count = 0
        for i in range(offset[s], offset[s + 1]):
            x, y, least = points[i, 0], points[i, 1], np.inf
            for k in range(2):
                across = corner[s, k, 0] * x + corner[s, k, 1] * y
                distance = abs(across + corner[s, k, 2])
                if exists(corner[s], k) and distance < tau:
                    least = min(least, distance / depth_std(across, x, y, (noise[0], noise[1])))
            if least < np.inf:
                ratio[count] = least
                count += 1
        if count > 0:
            excess[s] = max(1.0, median(ratio, count) / NORMAL_MEDIAN)
    return excess


@kernel(error_model="numpy")
def median(values: Floats, count: int) -> float:
    """Return the median of the first `count` values (N,), which are reordered; numpy's takes a second to compile."""
    upper = ranked(values, count, count // 2)
    if count % 2 == 1:
        return float(upper)
    lower = values[0]
    for i in range(1, count // 2):
        lower = max(lower, values[i])
    return float((lower + upper) / 2.0)


@kernel()
def ranked(values: Floats, count: int, rank: int) -> float:
    """Return the value that `rank` of the first `count` values (N,) precede, and move these before it (quickselect)."""
    low, high = 0, count - 1
    while low < high:
        pivot, i, j = values[(low + high) // 2], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i, j = i + 1, j - 1
        if rank <= j:
            high = j
        elif rank >= i:
            low = i
        else:
            break
    return float(values[rank])


@kernel(error_model="numpy")
def face_depths(
    x: Floats, y: Floats, corner: Floats, uncertainty: Floats, noise: tuple[float, float]
) -> tuple[Floats, Floats, Floats]:
    """Return depths behind both faces, places along them, and standard deviations that include those of the faces.

    All are (2, N). The depth of a face is most certain at its centre. Depths behind a missing face are infinite.
    """
    depth, place, std = np.empty((2, len(x))), np.empty((2, len(x))), np.empty((2, len(x)))
    for k in range(2):
        a, b, c, real = corner[k, 0], corner[k, 1], corner[k, 2], exists(corner, k)
        middle, variance, turn = uncertainty[k, 0], uncertainty[k, 1], uncertainty[k, 2]
        for i in range(len(x)):  # no branch: the compiler vectorises it
            across, along = a * x[i] + b * y[i], b * x[i] - a * y[i]
            away, own = along - middle, depth_std(across, x[i], y[i], noise)
            place[k, i], depth[k, i] = along, across + c if real else np.inf
            std[k, i] = math.sqrt(own * own + variance + away * away * turn) if real else 1.0
    return depth, place, std


@kernel()
def face_ends(depth: Floats, place: Floats, std: Floats, gate: float) -> tuple[Floats, Floats]:
    """Return the lowest and the highest place (2,) of the points on each face."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for i in range(depth.shape[1]):
        k = 0 if abs(depth[0, i]) * std[1, i] <= abs(depth[1, i]) * std[0, i] else 1
        if abs(depth[k, i]) < gate * std[k, i]:
            low[k], high[k] = min(low[k], place[k, i]), max(high[k], place[k, i])
    return low, high


@kernel()
def on_faces(depth: Floats, place: Floats, std: Floats, gate: float) -> tuple[Ints, Ints]:
    """Return the face (N,) that each point belongs to, -1 for none, and (N,) 1 for points outside any face.

    A point belongs to the nearest face if it is at most `CURVE_DEPTH_M` behind it and at most `CURVE_BEYOND_M` past its
    ends, the curvature of bumpers, flanks and rounded corners.
    """
    label, outside = np.full(depth.shape[1], -1, np.int64), np.zeros(depth.shape[1], np.int64)
    least = np.full(depth.shape[1], np.inf)
    low, high = face_ends(depth, place, std, gate)
    for k in range(2):
        is_end = high[k] - low[k] <= WIDTH_MAX < high[1 - k] - low[1 - k]
        for i in range(depth.shape[1]):
            if depth[k, i] < -gate * std[k, i] * (2.0 if is_end else 1.0):
                outside[i] = 1
            elif (
                depth[k, i] < CURVE_DEPTH_M
                and low[k] - CURVE_BEYOND_M < place[k, i] < high[k] + CURVE_BEYOND_M
                and abs(depth[k, i]) < least[i]
            ):
                least[i], label[i] = abs(depth[k, i]), k
    return label, outside


@kernel()
def unseen_sides(
    points: Floats,
    corner: Floats,
    depth: Floats,
    place: Floats,
    label: Ints,
    outside: Ints,
    slack: float,
    pitch: float,
) -> None:
    """Label the points along unseen sides, which start at those ends of a face where there is no other face.

    Points along such a side are body, as the edge of a hood above the front. Points farther out are mirrors or
    neighbours; the end is known to a beam spacing (`pitch` [rad]). Labels are 2 and up, one for each side.
    """
    for k in range(2 if exists(corner, 1) else 1):
        for sign in (1.0, -1.0):
            turn = corner[1 - k, 0] * corner[k, 1] - corner[1 - k, 1] * corner[k, 0]
            if exists(corner, 1) and sign * turn < 0.0:
                continue
            edge, start = -np.inf, np.inf
            for i in range(len(points)):
                if label[i] == k and outside[i] == 0:
                    edge, start = max(edge, sign * place[k, i]), min(start, sign * place[k, i])
            if edge - start < WHOLE_MIN:
                continue
            for i in range(len(points)):
                beyond = sign * place[k, i] - edge
                if depth[k, i] < CURVE_DEPTH_M or outside[i] == 1 or (label[i] >= 0 and label[i] != k):
                    continue
                if beyond > slack + pitch * elementary.hypot(points[i, 0], points[i, 1]):
                    outside[i] = 1
                elif beyond > -CURVE_DEPTH_M:
                    label[i] = 2 * k + (2 if sign > 0.0 else 3)


@kernel(error_model="numpy")
def drop_mirrors(height: Floats, label: Ints, depth: Floats, place: Floats, std: Floats) -> None:
    """Remove the points of mirrors in the plane of a face from its label; values (N,), heights [m].

    A third of a mirror's points, on its base, lie in that plane. They are identified by a point of the same mirror that
    is clearly outside.
    """
    sure = np.zeros(len(height), np.bool_)
    for i in range(len(height)):
        outside = -MIRROR_OUT < depth[i] < -MIRROR_GATE * std[i]
        sure[i] = label[i] < 0 and outside and height[i] > MIRROR_Z_MIN
    pending = sure.copy()
    for i in range(len(height)):
        if pending[i]:
            total, count = 0.0, 0
            for j in range(len(height)):
                if sure[j] and abs(place[j] - place[i]) < MIRROR_APART:
                    total, count = total + place[j], count + 1
            for j in range(len(height)):
                near = abs(place[j] - total / count) < MIRROR_HALF
                if near and abs(height[j] - height[i]) < MIRROR_HEIGHT:
                    pending[j] = False
                    if depth[j] < MIRROR_FOOT:
                        label[j] = -1


@kernel()
def keep_dominant(label: Ints, depth: Floats) -> None:
    """Label the point nearest to the dominant face 0 if there is no other on it; depths (2, N)."""
    nearest = 0
    for i in range(len(label)):
        if label[i] == 0:
            return
        nearest = i if abs(depth[0, i]) < abs(depth[0, nearest]) else nearest
    label[nearest] = 0


@kernel()
def label_bodies(
    points: Floats,
    height: Floats,
    offset: Ints,
    corner: Floats,
    uncertainty: Floats,
    noise: Floats,
    gate: Floats,
    pitch: float,
) -> tuple[Ints, Floats]:
    """Return the face (N,) of points (N, 2) on the bodies of segments, and headings of faces 0 (S,) [rad].

    Faces are 0 and 1 as in `corner` (S, 2, 3), 2 and up for unseen sides. Outliers are -1: points outside a face are
    mirrors or neighbours, points deep inside are seen through or over the body. Heights (N,) [m] identify mirrors.
    Segment s has points offset[s] to offset[s + 1], and gate[s].
    """
    label, heading = np.empty(len(points), np.int64), np.empty(len(corner))
    for s in range(len(corner)):
        own, faces = points[offset[s] : offset[s + 1]], corner[s]
        depth, place, std = face_depths(*columns(own), faces, uncertainty[s], (noise[0], noise[1]))
        member, outside = on_faces(depth, place, std, gate[s])
        unseen_sides(own, faces, depth, place, member, outside, gate[s] * noise[1], pitch)
        for i in range(len(own)):
            member[i] = -1 if outside[i] == 1 else member[i]  # a loop: slices of arrays take long to compile
        for k in range(2):
            if k == 0 or exists(faces, 1):
                drop_mirrors(height[offset[s] : offset[s + 1]], member, depth[k], place[k], std[k])
        keep_dominant(member, depth)
        for i in range(len(own)):
            label[offset[s] + i] = member[i]
        heading[s] = elementary.atan2(-faces[0, 0], faces[0, 1])
    return label, heading

"""Kernels of the outline: separate the points on a body with known faces from outliers."""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.faces import depth_std, exists
from luxloop.tracker.detection.kernels.groups import columns

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
def on_faces(
    depth: Floats, place: Floats, std: Floats, gate: float, depth_max: float, beyond_max: float
) -> tuple[Ints, Ints]:
    """Return the face (N,) that each point belongs to, -1 for none, and (N,) 1 for points outside any face.

    A point belongs to the nearest face if it is at most `depth_max` behind it and at most `beyond_max` past its ends,
    the curvature of bumpers, flanks and rounded corners.
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
                depth[k, i] < depth_max
                and low[k] - beyond_max < place[k, i] < high[k] + beyond_max
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
    depth_max: float,
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
                if depth[k, i] < depth_max or outside[i] == 1 or (label[i] >= 0 and label[i] != k):
                    continue
                if beyond > slack + pitch * math.hypot(points[i, 0], points[i, 1]):
                    outside[i] = 1
                elif beyond > -depth_max:
                    label[i] = 2 * k + (2 if sign > 0.0 else 3)


@kernel(error_model="numpy")
def drop_mirrors(points: Floats, label: Ints, depth: Floats, place: Floats, std: Floats) -> None:
    """Remove the points (N, 3) of mirrors in the plane of a face from its label; values (N,) for that face.

    A third of a mirror's points, on its base, lie in that plane. They are identified by a point of the same mirror that
    is clearly outside.
    """
    sure = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        outside = -MIRROR_OUT < depth[i] < -MIRROR_GATE * std[i]
        sure[i] = label[i] < 0 and outside and points[i, 2] > MIRROR_Z_MIN
    pending = sure.copy()
    for i in range(len(points)):
        if pending[i]:
            total, count = 0.0, 0
            for j in range(len(points)):
                if sure[j] and abs(place[j] - place[i]) < MIRROR_APART:
                    total, count = total + place[j], count + 1
            for j in range(len(points)):
                near = abs(place[j] - total / count) < MIRROR_HALF
                if near and abs(points[j, 2] - points[i, 2]) < MIRROR_HEIGHT:
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
    offset: Ints,
    corner: Floats,
    uncertainty: Floats,
    noise: Floats,
    gate: Floats,
    depth_max: float,
    beyond_max: float,
    pitch: float,
) -> tuple[Ints, Floats]:
    """Return the face of each of the points (N, 2 or 3) on the bodies of segments, and headings of faces 0 (S,) [rad].

    Faces are 0 and 1 as in `corner` (S, 2, 3), 2 and up for unseen sides. Outliers are -1: points outside a face are
    mirrors or neighbours, points deep inside are seen through or over the body. Segment s has points offset[s] to
    offset[s + 1], and gate[s].
    """
    label, heading = np.empty(len(points), np.int64), np.empty(len(corner))
    for s in range(len(corner)):
        own, faces = points[offset[s] : offset[s + 1]], corner[s]
        depth, place, std = face_depths(*columns(own), faces, uncertainty[s], (noise[0], noise[1]))
        member, outside = on_faces(depth, place, std, gate[s], depth_max, beyond_max)
        unseen_sides(own, faces, depth, place, member, outside, gate[s] * noise[1], pitch, depth_max)
        for i in range(len(own)):
            member[i] = -1 if outside[i] == 1 else member[i]  # a loop: slices of arrays take long to compile
        for k in range(2 if points.shape[1] > 2 else 0):
            if k == 0 or exists(faces, 1):
                drop_mirrors(own, member, depth[k], place[k], std[k])
        keep_dominant(member, depth)
        for i in range(len(own)):
            label[offset[s] + i] = member[i]
        heading[s] = math.atan2(-faces[0, 0], faces[0, 1])
    return label, heading

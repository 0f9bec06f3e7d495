"""Hot loops of the outline: which points of a segment lie on the body whose faces are known."""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.faces import depths, exists

WIDTH_MAX = 2.8
"""[m] Of vehicles; a longer face is a flank. Mirrors stick out of flanks only: out of a front or rear just stray ranges
do, and those are given twice the gate."""
WHOLE_MIN = 1.0
"""[m] What is seen of a face, from which its ends may be taken for the vehicle's."""
MIRROR_OUT = 0.35
"""[m] How far a mirror sticks out at most, trucks' included."""
MIRROR_HALF = 0.08
"""[m] From a mirror's middle to its ends along the flank."""
MIRROR_APART = 0.2
"""[m] Places of one mirror along the flank are no farther apart."""
MIRROR_Z_MIN = 0.75
"""[m] Mirrors hang higher; a car's has its lower edge at 0.9."""
MIRROR_HEIGHT = 0.12
"""[m] Between the points of a mirror on different layers."""
MIRROR_FOOT = 0.06
"""[m] How deep inside the side a mirror's foot is."""
MIRROR_GATE = 4.0
"""Standard deviations by which a point is sure to be on a mirror; what is near it in height and place is as well."""


@njit(cache=True)
def face_depths(points: Floats, corner: Floats, surety: Floats, noise: Floats) -> tuple[Floats, Floats, Floats]:
    """Depths behind both faces, places along them and standard deviations of the depths (2, N), the faces' included.

    A face is surest in its middle. Behind a face that is not there everything is infinitely deep.
    """
    shape = (2, len(points))
    depth, place, std = np.full(shape, np.inf), np.zeros(shape), np.ones(shape)
    for k in range(2):
        if exists(corner[k]):
            depth[k], place[k], std[k] = depths(points, corner[k], noise)
            std[k] = np.sqrt(std[k] ** 2 + surety[k, 1] + (place[k] - surety[k, 0]) ** 2 * surety[k, 2])
    return depth, place, std


@njit(cache=True)
def face_ends(depth: Floats, place: Floats, std: Floats, gate: float) -> tuple[Floats, Floats]:
    """Lowest and highest place of the points on each face, (2,) and (2,)."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for i in range(depth.shape[1]):
        k = 0 if abs(depth[0, i]) * std[1, i] <= abs(depth[1, i]) * std[0, i] else 1
        if abs(depth[k, i]) < gate * std[k, i]:
            low[k], high[k] = min(low[k], place[k, i]), max(high[k], place[k, i])
    return low, high


@njit(cache=True)
def on_faces(
    depth: Floats, place: Floats, std: Floats, gate: float, depth_max: float, beyond_max: float
) -> tuple[Ints, Ints]:
    """(N,) nearest face of each point that is right behind one, -1 for none, and (N,) 1 if it is outside of any.

    Right behind is no deeper than `depth_max`, and no farther than `beyond_max` past its ends: bumpers, flanks and
    rounded corners curve so far.
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


@njit(cache=True)
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
    """Judge what lies behind a face by the end of it where no other face is: there is an unseen side of the body.

    Points along it are body: a hood's edge, seen over the front. What lies farther out is a mirror or a neighbour; the
    end is only known to a beam's width (`pitch` [rad]). Labels are 2 and up, a number for each such side.
    """
    for k in range(2 if exists(corner[1]) else 1):
        for sign in (1.0, -1.0):
            turn = corner[1 - k, 0] * corner[k, 1] - corner[1 - k, 1] * corner[k, 0]
            if exists(corner[1]) and sign * turn < 0.0:
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


@njit(cache=True)
def drop_mirrors(height: Floats, label: Ints, depth: Floats, place: Floats, std: Floats) -> None:
    """Take away the points of mirrors that lie in the plane of a face: (N,) values for that face.

    A third of a mirror's points do, on its foot. They are known by a point of it that is surely outside.
    """
    sure = (label < 0) & (depth > -MIRROR_OUT) & (depth < -MIRROR_GATE * std) & (height > MIRROR_Z_MIN)
    todo = sure.copy()
    for i in np.flatnonzero(sure):
        if todo[i]:
            middle = np.mean(place[sure & (np.abs(place - place[i]) < MIRROR_APART)])
            here = (np.abs(place - middle) < MIRROR_HALF) & (np.abs(height - height[i]) < MIRROR_HEIGHT)
            todo[here] = False
            label[here & (depth < MIRROR_FOOT)] = -1


@njit(cache=True)
def judge(
    points: Floats,
    corner: Floats,
    surety: Floats,
    noise: Floats,
    gate: float,
    depth_max: float,
    beyond_max: float,
    pitch: float,
) -> Ints:
    """Face of each of the points (N, 2 or 3) that are body: 0 and 1 as in `corner`, more for unseen sides; -1 for none.

    Outside of a face is a mirror or a neighbour; deep inside is what is seen through or over the body.
    """
    depth, place, std = face_depths(points, corner, surety, noise)
    label, outside = on_faces(depth, place, std, gate, depth_max, beyond_max)
    unseen_sides(points, corner, depth, place, label, outside, gate * noise[1], pitch, depth_max)
    label[outside == 1] = -1
    if points.shape[1] > 2:
        for k in range(2 if exists(corner[1]) else 1):
            drop_mirrors(points[:, 2], label, depth[k], place[k], std[k])
    if not np.any(label == 0):
        label[np.argmin(np.abs(depth[0]))] = 0
    return label

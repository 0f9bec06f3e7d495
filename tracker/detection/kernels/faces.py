"""Kernels of faces: fit one side of a vehicle, or two perpendicular ones, to points.

A face is a line (3,) whose unit normal points into the body, so that face . (x, y, 1) is a point's depth behind it.
A corner (2, 3) contains the faces of one vehicle; the second is zeros if only one is visible.
"""

import math

import numpy as np
from numba import njit

from tracker.arrays import Floats, Ints

EGO_REACH = 2.5
"""Distance from the ego's centre to its farthest unit [m]."""
NORMAL_MEDIAN = 0.6745
"""Median of the absolute value of a standard normal variable."""
ROUNDS = 2
"""Iterations of assigning points to faces and fitting the faces; a third one has a negligible effect."""


@njit(cache=True)
def inward(points: Floats, line: Floats, tau: float) -> Floats:
    """Orient the normal of a line into the body.

    The ego is outside. If it is so near the line that its units may be on either side, the other points decide: more
    points of a body lie behind a face than in front of it.
    """
    side = -line[2]
    if abs(line[2]) < EGO_REACH:
        balance = 0
        for i in range(len(points)):
            depth = line[0] * points[i, 0] + line[1] * points[i, 1] + line[2]
            if abs(depth) > tau:
                balance += 1 if depth > 0.0 else -1
        side = float(balance) if balance != 0 else side
    return line if side > 0.0 else -line


@njit(cache=True)
def exists(face: Floats) -> bool:
    """Return True for a face, False for zeros."""
    return bool(face[0] != 0.0 or face[1] != 0.0)


@njit(cache=True, error_model="numpy")
def depths(points: Floats, face: Floats, noise: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the depth behind the face, the place along it, and the standard deviation of the depth (N,) [m].

    Range noise noise[0] is along the beam; the flatness of sides is noise[1]. At grazing incidence the range noise has
    little effect on the depth.
    """
    depth, place, std = np.empty(len(points)), np.empty(len(points)), np.empty(len(points))
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        across = face[0] * x + face[1] * y
        depth[i], place[i] = across + face[2], face[1] * x - face[0] * y
        slant = noise[0] * across / max(math.sqrt(x * x + y * y), 1e-9)
        std[i] = math.sqrt(slant * slant + noise[1] * noise[1])
    return depth, place, std


@njit(cache=True, error_model="numpy")
def nearest_face(points: Floats, corner: Floats, noise: Floats, gate: float) -> tuple[Ints, Floats, Floats]:
    """Return the face (N,) of each point that lies within `gate` standard deviations of one, or -1.

    The other results are the distance from that face (N,) in standard deviations, and the weight (N,) of the point,
    1 / variance [1/m^2].
    """
    member, least, weight = np.full(len(points), -1, np.int64), np.full(len(points), gate), np.zeros(len(points))
    real = exists(corner[0]), exists(corner[1])
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        range_m = max(math.sqrt(x * x + y * y), 1e-9)
        for k in range(2):
            if real[k]:
                across = corner[k, 0] * x + corner[k, 1] * y
                slant = noise[0] * across / range_m
                std, distance = math.sqrt(slant * slant + noise[1] * noise[1]), abs(across + corner[k, 2])
                if distance < least[i] * std:
                    least[i], member[i], weight[i] = distance / std, k, 1.0 / std**2
    return member, least, weight


@njit(cache=True)
def moments(points: Floats, member: Ints, k: int, weights: Floats) -> Floats:
    """(6,) total weight, mean x, mean y, and weighted sums of xx, xy and yy about the mean, of the points on face k."""
    total, x, y = 0.0, 0.0, 0.0
    for i in range(len(points)):
        if member[i] == k:
            weight = weights[i]
            total, x, y = total + weight, x + weight * points[i, 0], y + weight * points[i, 1]
    if total == 0.0:
        return np.zeros(6)
    x, y = x / total, y / total
    xx, xy, yy = 0.0, 0.0, 0.0
    for i in range(len(points)):
        if member[i] == k:
            weight, dx, dy = weights[i], points[i, 0] - x, points[i, 1] - y
            xx, xy, yy = xx + weight * dx * dx, xy + weight * dx * dy, yy + weight * dy * dy
    return np.array([total, x, y, xx, xy, yy])


@njit(cache=True)
def through(face: Floats, normal_angle: float, x: float, y: float) -> Floats:
    """Return the face (3,) with a normal (or its opposite) through a point."""
    a, b = math.cos(normal_angle), math.sin(normal_angle)
    if a * face[0] + b * face[1] < 0.0:
        a, b = -a, -b
    return np.array([a, b, -a * x - b * y])


@njit(cache=True)
def fit_corner(points: Floats, corner: Floats, noise: Floats, gate: float) -> tuple[Floats, Floats]:
    """Fit one heading and the place of each face to the points on them, by weighted total least squares.

    Rotating the points of one face by a right angle adds their moments to those of the other. The face with more
    information on the heading comes first, sum((place - mean)^2 / variance) [1/rad^2]: a sparse flank of 4 m before a
    dense bumper of 1.5 m.

    Returns
    -------
    corner
        (2, 3).
    uncertainty
        (2, 3) mean place of each face [m], variance of its depth there [m^2], and variance of the common direction
        [rad^2].
    """
    moment = np.zeros((2, 6))
    for _ in range(ROUNDS):
        member, _, weight = nearest_face(points, corner, noise, gate)
        for k in range(2):
            moment[k] = moments(points, member, k, weight)
        if moment[0, 0] == 0.0:
            break
        xx, yy = moment[0, 3] + moment[1, 5], moment[0, 5] + moment[1, 3]
        direction = 0.5 * math.atan2(2.0 * (moment[0, 4] - moment[1, 4]), xx - yy)
        for k in range(2):
            if moment[k, 0] > 0.0:
                corner[k] = through(corner[k], direction + 0.5 * math.pi * (1 - k), moment[k, 1], moment[k, 2])
            else:
                corner[k] = 0.0
    information = moment[:, 3] + moment[:, 5]
    uncertainty = np.empty((2, 3))
    for k in range(2):
        uncertainty[k, 0] = corner[k, 1] * moment[k, 1] - corner[k, 0] * moment[k, 2]
        uncertainty[k, 1] = 1.0 / max(moment[k, 0], 1e-9)
        uncertainty[k, 2] = 1.0 / max(information.sum(), 1e-9)
    if information[1] > information[0]:
        return corner[::-1].copy(), uncertainty[::-1].copy()
    return corner, uncertainty


@njit(cache=True, error_model="numpy")
def excess(points: Floats, corner: Floats, noise: Floats, tau: float) -> float:
    """Return the ratio of the points' deviation from their face to their noise, at least 1.

    Based on the median of |depth| / std of the points within tau of a face, which is 0.67 for normal noise. Real sides
    are curved.
    """
    ratio, count = np.empty(len(points)), 0
    real = exists(corner[0]), exists(corner[1])
    for i in range(len(points)):
        x, y, least = points[i, 0], points[i, 1], np.inf
        range_m = max(math.sqrt(x * x + y * y), 1e-9)
        for k in range(2):
            across = corner[k, 0] * x + corner[k, 1] * y
            distance, slant = abs(across + corner[k, 2]), noise[0] * across / range_m
            if real[k] and distance < tau:
                least = min(least, distance / math.sqrt(slant * slant + noise[1] * noise[1]))
        if least < np.inf:
            ratio[count] = least
            count += 1
    return max(1.0, np.median(ratio[:count]) / NORMAL_MEDIAN) if count > 0 else 1.0

"""Kernels of faces: fit one side of a vehicle, or two perpendicular ones, to points.

A face is a line (3,) whose unit normal points into the body, so that face . (x, y, 1) is a point's depth behind it.
A corner (2, 3) contains the faces of one vehicle; the second is zeros if only one is visible.
"""

import math

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.compiled import kernel

EGO_REACH = 2.5
"""Distance from the ego's centre to its farthest unit [m]."""
NORMAL_MEDIAN = 0.6745
"""Median of the absolute value of a standard normal variable."""
ROUNDS = 2
"""Iterations of assigning points to faces and fitting the faces; a third one has a negligible effect."""


@kernel()
def faces_away(points: Floats, line: Floats, tau: float) -> bool:
    """Return True if the normal of a line points out of the body.

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
    return bool(side <= 0.0)


@kernel()
def exists(corner: Floats, k: int) -> bool:
    """Return True if a corner (2, 3) has face k."""
    return bool(corner[k, 0] != 0.0 or corner[k, 1] != 0.0)


@kernel(error_model="numpy")
def depth_std(across: float, x: float, y: float, noise: Floats) -> float:
    """Return the standard deviation of the depth of a point behind a face [m]; `across` is normal . (x, y).

    Range noise noise[0] is along the beam; the flatness of sides is noise[1]. At grazing incidence the range noise has
    little effect on the depth.
    """
    slant = noise[0] * across / max(math.sqrt(x * x + y * y), 1e-9)
    return math.sqrt(slant * slant + noise[1] * noise[1])


@kernel(error_model="numpy")
def nearest_face(points: Floats, corner: Floats, noise: Floats, gate: float, member: Ints, weight: Floats) -> None:
    """Write the face (N,) of each point that lies within `gate` standard deviations of one, or -1.

    The other result is the weight (N,) of a point on a face, 1 / variance [1/m^2].
    """
    for i in range(len(points)):
        x, y, least = points[i, 0], points[i, 1], gate
        member[i] = -1
        for k in range(2):
            if exists(corner, k):
                across = corner[k, 0] * x + corner[k, 1] * y
                std, distance = depth_std(across, x, y, noise), abs(across + corner[k, 2])
                if distance < least * std:
                    least, member[i], weight[i] = distance / std, k, 1.0 / std**2


@kernel(error_model="numpy")
def moments(points: Floats, member: Ints, k: int, weights: Floats, moment: Floats) -> None:
    """Write total weight, mean x, mean y, and weighted sums of xx, xy and yy about the mean, of face k to row k."""
    total, x, y = 0.0, 0.0, 0.0
    for i in range(len(points)):
        if member[i] == k:
            weight = weights[i]
            total, x, y = total + weight, x + weight * points[i, 0], y + weight * points[i, 1]
    moment[k] = 0.0
    if total == 0.0:
        return
    x, y = x / total, y / total
    xx, xy, yy = 0.0, 0.0, 0.0
    for i in range(len(points)):
        if member[i] == k:
            weight, dx, dy = weights[i], points[i, 0] - x, points[i, 1] - y
            xx, xy, yy = xx + weight * dx * dx, xy + weight * dx * dy, yy + weight * dy * dy
    moment[k, 0], moment[k, 1], moment[k, 2] = total, x, y
    moment[k, 3], moment[k, 4], moment[k, 5] = xx, xy, yy


@kernel()
def set_face(corner: Floats, k: int, normal_angle: float, x: float, y: float) -> None:
    """Move face k of a corner through a point; turn its normal to an angle or its opposite [rad]."""
    a, b = math.cos(normal_angle), math.sin(normal_angle)
    if a * corner[k, 0] + b * corner[k, 1] < 0.0:
        a, b = -a, -b
    corner[k, 0], corner[k, 1], corner[k, 2] = a, b, -a * x - b * y


@kernel(error_model="numpy")
def fit_corner(
    points: Floats, corner: Floats, noise: Floats, gate: float, uncertainty: Floats, information: Floats
) -> None:
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
    moment, member, weight = np.zeros((2, 6)), np.empty(len(points), np.int64), np.empty(len(points))
    for _ in range(ROUNDS):
        nearest_face(points, corner, noise, gate, member, weight)
        for k in range(2):
            moments(points, member, k, weight, moment)
        if moment[0, 0] == 0.0:
            break
        xx, yy = moment[0, 3] + moment[1, 5], moment[0, 5] + moment[1, 3]
        direction = 0.5 * math.atan2(2.0 * (moment[0, 4] - moment[1, 4]), xx - yy)
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
    for s in range(len(corner)):
        own = points[offset[s] : offset[s + 1]]
        fit_corner(own, corner[s], noise, gate[s], uncertainty[s], information[s])
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
                    least = min(least, distance / depth_std(across, x, y, noise))
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

"""Kernels of faces: fit one side of a vehicle, or two perpendicular ones, to points.

A face is a line (3,) whose unit normal points into the body, so that face . (x, y, 1) is a point's depth behind it.
A corner (2, 3) contains the faces of one vehicle; the second is zeros if only one is visible.
"""

import math

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.detection.kernels.groups import columns

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
    a, b = math.cos(normal_angle), math.sin(normal_angle)
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

"""Points against the outlines of their bodies in plan: parts, causes and faces."""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Bytes, Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.motion import straight_point, turned
from luxloop.sensor_model.kernels.records import OutlinedBodies
from luxloop.sensor_model.returns import GROUND
from luxloop.sensor_model.truth import Cause, Part

_GROUND, _OBSTACLE, _MIRROR = int(Part.GROUND), int(Part.OBSTACLE), int(Part.MIRROR)
_ON_MIRROR, _OVERLAP = int(Cause.MIRROR), int(Cause.LAYER_OVERLAP)


@kernel()
def label_echoes(
    target: Ints, surface: Ints, points: Floats, plane_part: Bytes, bodies: OutlinedBodies, deepest: float
) -> tuple[Bytes, Bytes, Floats]:
    """Return (N,) part, (N,) cause and (N, 2) point with articulation removed, zero off actors, of N echoes.

    Parameters
    ----------
    target, surface, points
        (N,), (N,), (N, 3) as in `Echoes`.
    deepest
        Largest depth of a clean point inside the outline [m].
    """
    _, _, turn, pivot, first_edge, edges = bodies
    part, cause = np.empty(len(target), np.uint8), np.zeros(len(target), np.uint8)
    straight = np.zeros((len(target), 2))
    for e in range(len(target)):
        a, q = target[e], surface[e]
        if a < 0:
            part[e] = _GROUND if a == GROUND else _OBSTACLE
            continue
        x, y = straight_point(points[e, 0], points[e, 1], turn[q], pivot[q])
        straight[e, 0], straight[e, 1], part[e] = x, y, plane_part[q]
        if plane_part[q] == _MIRROR:
            cause[e] = _ON_MIRROR
        elif nearest_edge(edges, first_edge[a], first_edge[a + 1], x, y)[1] > deepest:
            cause[e] = _OVERLAP
    return part, cause, straight


@kernel()
def count_on_faces(
    clean: Bools, target: Ints, surface: Ints, points: Floats, unit: Bytes, origin: Floats, bodies: OutlinedBodies,
    size: Floats, min_facing: float,
) -> Ints:  # fmt: skip
    """Return the (A, 4) number of points on the front, left, rear and right of each body.

    A point is on a face if its surface and the nearest edge of the outline face that way, and its unit is in front.

    Parameters
    ----------
    clean, target, surface, points, unit
        (N,), (N,), (N,), (N, 2), (N,) of each return: True on an outline, fields of `returns.Returns`, and unit.
    origin
        (U, 3) position of each unit in the ego frame [m].
    size
        (A, 3) length, width, height [m].
    min_facing
        Least cosine between the normals and the face's.
    """
    pose, planes, turn, pivot, first_edge, edges = bodies
    cos, sin = np.empty(len(pose)), np.empty(len(pose))
    for a in range(len(pose)):
        cos[a], sin[a] = elementary.cos(pose[a, 2]), elementary.sin(pose[a, 2])
    count = np.zeros((len(pose), 4), np.int64)
    for i in range(len(target)):
        a, q, u = target[i], surface[i], unit[i]
        if a < 0 or not clean[i]:
            continue
        normal = turned(planes[q, 0], planes[q, 1], -turn[q])
        edge, _ = nearest_edge(edges, first_edge[a], first_edge[a + 1], points[i, 0], points[i, 1])
        dx, dy = origin[u, 0] - pose[a, 0], origin[u, 1] - pose[a, 1]
        x, y = cos[a] * dx + sin[a] * dy, cos[a] * dy - sin[a] * dx
        lidar = straight_point(x, y, turn[q], pivot[q])
        for face in range(4):
            axis, side = face % 2, 1.0 if face < 2 else -1.0
            facing = min(side * normal[axis], side * edges[edge, axis]) > min_facing
            if facing and side * lidar[axis] > 0.5 * size[a, axis]:
                count[a, face] += 1
    return count


@kernel(inline="always")
def nearest_edge(edges: Floats, begin: int, end: int, x: float, y: float) -> tuple[int, float]:
    """Return the nearest of the edges [begin, end) to a point inside a convex outline, and its distance [m].

    `edges` (E, 3) are outward unit normals in plan, and offsets [m]. The distance is negative outside.
    """
    nearest, depth = begin, math.inf
    for k in range(begin, end):
        inside = edges[k, 2] - edges[k, 0] * x - edges[k, 1] * y
        if inside < depth:
            nearest, depth = k, inside
    return nearest, depth

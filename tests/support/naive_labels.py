"""Slow reference implementations of the kernels that move and label echoes on bodies, one point at a time."""

import cmath
import itertools
import math

import numpy as np
import scipy
import shapely
from support.solid_mesh import corners, pieces

_SIDES = ((0, 1), (1, 1), (0, -1), (1, -1))
"""Axis and direction of front, left, rear and right."""


def straight(bodies, plane, point):
    """Return x, y of a point with the articulation of its plane removed."""
    back = cmath.exp(-1j * bodies.plane_turn[plane])
    x, *moved = bodies.plane_pivot[plane]
    place = x + back * (complex(*point[:2]) - complex(*moved))
    return np.array([place.real, place.imag])


def relief_shift(bodies, actor, plane, point, direction, scale):
    """Return how far along its beam the relief moves an echo [m]."""
    place = [*straight(bodies, plane, point), point[2]]
    waves = [math.cos(np.dot(wave[:3], place) + wave[3]) for wave in bodies.relief_waves[actor]]
    height = scale * bodies.plane_relief[plane] * math.sqrt(2 / len(waves)) * math.fsum(waves)
    return -height / max(0.3, -np.dot(bodies.planes[plane, :3], direction))


def surface_velocity(bodies, actor, point, ego_velocity, ego_yaw_rate):
    """Return x, y of the velocity of a point of an actor in the frame of the moving ego, by finite differences."""
    centre, velocity = complex(*bodies.pose_ego[actor, :2]), complex(*bodies.velocity_ego[actor])

    def place(time):
        on_road = centre + velocity * time + cmath.exp(1j * bodies.yaw_rate[actor] * time) * (complex(*point) - centre)
        return cmath.exp(-1j * ego_yaw_rate * time) * (on_road - complex(*ego_velocity) * time)

    step = 1e-4
    change = (place(step) - place(-step)) / (2 * step)
    return np.array([change.real, change.imag])


def outlines(bodies):
    """Return the outline of each body with its articulation, in plan; for bodies that are not articulated."""
    found = []
    for row in range(len(bodies)):
        outer = [piece for piece in pieces(bodies, row) if not (piece.inner or piece.part[0] == 5)]
        points = np.concatenate([corners(piece.planes)[:, :2] for piece in outer])
        found.append(shapely.Polygon(points[scipy.spatial.ConvexHull(points).vertices]))
    return found


def depth_and_normal(polygon, point):
    """Return the distance of a point inside a polygon, negative outside, and the normal of the nearest side."""
    ring = np.array(polygon.exterior.coords)
    sides = [shapely.LineString(side) for side in itertools.pairwise(ring)]
    nearest = min(range(len(sides)), key=lambda k: sides[k].distance(shapely.Point(point)))
    along = ring[nearest + 1] - ring[nearest]
    outward = np.array([along[1], -along[0]]) * (1 if shapely.is_ccw(polygon.exterior) else -1) / np.hypot(*along)
    inside = polygon.contains(shapely.Point(point))
    return (1 if inside else -1) * polygon.exterior.distance(shapely.Point(point)), outward


def faces_of(bodies, actor, plane, polygon, point, lidar, size):
    """Return four marks: the faces front, left, rear, right that a clean point belongs to, seen from a LIDAR."""
    turned = complex(*bodies.planes[plane, :2]) * cmath.exp(-1j * bodies.plane_turn[plane])
    _, side_normal = depth_and_normal(polygon, point)
    x, y, yaw = bodies.pose_ego[actor]
    seen = complex(lidar[0] - x, lidar[1] - y) * cmath.exp(-1j * yaw)
    seen = straight(bodies, plane, [seen.real, seen.imag])
    normals = np.array([[turned.real, turned.imag], side_normal])
    limit = math.cos(math.radians(30))
    return [
        bool(np.all(side * normals[:, axis] > limit) and side * seen[axis] > size[axis] / 2) for axis, side in _SIDES
    ]

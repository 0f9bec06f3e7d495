"""Bodies as triangle meshes, by computational geometry that shares nothing with the caster."""

import numpy as np
import trimesh
from scipy.optimize import linprog
from scipy.spatial import HalfspaceIntersection


def corners(planes):
    """(V, 3) corners of the convex solid {p : n . p <= d}, planes (K, 4)."""
    normals, offsets = planes[:, :3], planes[:, 3]
    # Centre of the largest ball inside: maximise r subject to n . c + r <= d.
    bounds = [(None, None)] * 3 + [(0.0, None)]
    ball = linprog([0, 0, 0, -1], A_ub=np.column_stack([normals, np.ones(len(planes))]), b_ub=offsets, bounds=bounds)
    halfspaces = np.column_stack([normals, -offsets])
    return HalfspaceIntersection(halfspaces, ball.x[:3]).intersections


def body_mesh(solids):
    """One mesh of all solids, in the frame of the body."""
    return trimesh.util.concatenate([trimesh.convex.convex_hull(corners(solid.planes)) for solid in solids])


def placed(mesh, pose):
    """A copy of the mesh at a pose x, y [m], yaw [rad]."""
    x, y, yaw = pose
    cos, sin = np.cos(yaw), np.sin(yaw)
    return mesh.copy().apply_transform([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])

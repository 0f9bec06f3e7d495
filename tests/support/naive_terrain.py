"""Slow reference implementation of rays on uneven ground: one ray against all triangles."""

from itertools import product

import numpy as np


def triangles_of(terrain, margin=0):
    """Return the (T, 3, 3) triangles of a terrain in the world frame, continued outwards by `margin` cells."""
    height = np.pad(terrain.height, margin, "edge")
    triangles = []
    for i, j in product(*(range(count - 1) for count in height.shape)):
        for corners in (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))):
            places = [terrain.corner_world + terrain.cell * (np.array([i + a, j + b]) - margin) for a, b in corners]
            triangles.append([(*place, height[i + a, j + b]) for place, (a, b) in zip(places, corners, strict=True)])
    return np.array(triangles)


def first_range(origin, direction, triangles):
    """Return range and cosine of incidence of the first triangle that a ray meets from above (Moller, Trumbore 1997).

    The range is infinite if there is none.
    """
    first, one, other = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(direction, other)
    determinant = (one * across).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        to = origin - first
        u = (to * across).sum(axis=1) / determinant
        turned = np.cross(to, one)
        v = turned @ direction / determinant
        at = (other * turned).sum(axis=1) / determinant
    met = (u >= 0) & (v >= 0) & (u + v <= 1) & (at > 0) & (determinant > 0)
    if not met.any():
        return np.inf, 0.0
    best = np.flatnonzero(met)[np.argmin(at[met])]
    normal = np.cross(one[best], other[best])
    return at[best], -direction @ normal / np.linalg.norm(normal)

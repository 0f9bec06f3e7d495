"""Bodies as points and triangle meshes, by computational geometry that is independent of the caster."""

from dataclasses import dataclass

import numpy as np
import scipy
from support.optional import need


@dataclass(frozen=True)
class Piece:
    """Solid of a body, extracted from the flat record."""

    planes: np.ndarray
    part: np.ndarray
    inner: bool
    tractor: bool
    bounds: np.ndarray

    def faces(self):
        """Yield the ordered corners and the part of each plane that has a face."""
        points = corners(self.planes)
        for plane, part in zip(self.planes, self.part, strict=True):
            on_face = points[np.abs(points @ plane[:3] - plane[3]) < 1e-9]
            if len(on_face) >= 3:
                middle, across = on_face.mean(axis=0), np.linalg.svd(plane[None, :3])[2][1:]
                u, v = across @ (on_face - middle).T
                yield on_face[np.argsort(np.arctan2(v, u))], int(part)


def pieces(bodies, row):
    """Return the solids of one body."""
    found = []
    for solid in range(bodies.body_solid[row], bodies.body_solid[row + 1]):
        planes = slice(bodies.solid_plane[solid], bodies.solid_plane[solid + 1])
        found.append(
            Piece(
                planes=bodies.planes[planes],
                part=bodies.plane_part[planes],
                inner=bool(bodies.solid_inner[solid]),
                tractor=bool(bodies.solid_ahead[solid] > 0),
                bounds=bodies.solid_bounds[solid],
            )
        )
    return found


def corners(planes):
    """Return the (V, 3) corners of the convex solid {p : n . p <= d}, planes (K, 4)."""
    normals, offsets = planes[:, :3], planes[:, 3]
    # Centre of the largest ball inside: maximise r subject to n . c + r <= d.
    bounds = [(None, None)] * 3 + [(0.0, None)]
    ball = scipy.optimize.linprog(
        [0, 0, 0, -1], A_ub=np.column_stack([normals, np.ones(len(planes))]), b_ub=offsets, bounds=bounds
    )
    halfspaces = np.column_stack([normals, -offsets])
    return scipy.spatial.HalfspaceIntersection(halfspaces, ball.x[:3]).intersections


def body_mesh(solids):
    """Return one mesh of solids with planes (K, 4), in the frame of the body."""
    need("dev", "trimesh")
    import trimesh

    return trimesh.util.concatenate([trimesh.convex.convex_hull(corners(solid.planes)) for solid in solids])


def placed(mesh, pose):
    """Return a copy of the mesh at a pose x, y [m], yaw [rad]."""
    x, y, yaw = pose
    cos, sin = np.cos(yaw), np.sin(yaw)
    return mesh.copy().apply_transform([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])


def embree_ranges(origins, directions, scene):
    """Return the (N,) range of the first hit of each ray on a mesh, infinite without a hit; traced by Embree."""
    assert type(scene.ray).__module__.endswith("ray_pyembree")
    _, ray, place = scene.ray.intersects_id(origins, directions, multiple_hits=False, return_locations=True)
    ranges = np.full(len(origins), np.inf)
    ranges[ray] = np.linalg.norm(place - origins[ray], axis=1)
    return ranges

"""Slow reference implementation of the caster's geometry: one ray against all surfaces, one at a time."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from luxloop.sensor_model.returns import GROUND, WALL

_MASK = 0xFFFFFFFF


class Ray(NamedTuple):
    origin: tuple[float, float, float]
    direction: tuple[float, float, float]


class Hit(NamedTuple):
    """Intersection of a ray and a surface."""

    range: float
    target: int
    surface: int
    cosine: float


class Solid(NamedTuple):
    inner: bool
    first: int
    """Row of the first of its planes."""
    planes: list[list[float]]


class Scene(NamedTuple):
    """All surfaces at one instant, in the ego frame of the frame's time."""

    poses: list[tuple[float, float, float]]
    """x, y, yaw of each body."""
    solids: list[list[Solid]]
    """Solids of each body."""
    walls: list[tuple[float, ...]]
    """x, y of one end, x, y of the other, lower and upper edge."""


def scene_at(bodies, walls, tau):
    """Return bodies and walls at a time offset from the frame [s]."""
    motions = zip(bodies.pose_ego, bodies.velocity_ego, bodies.acceleration_ego, bodies.yaw_rate, strict=True)
    return Scene(
        poses=[pose_at(*motion, tau) for motion in motions],
        solids=[solids_of_body(bodies, a) for a in range(len(bodies))],
        walls=[(*ends, *z) for ends, z in zip(walls.ends.tolist(), walls.z.tolist(), strict=True)],
    )


def solids_of_body(bodies, a):
    solids = []
    for p in range(bodies.body_solid[a], bodies.body_solid[a + 1]):
        first, last = bodies.solid_plane[p : p + 2].tolist()
        solids.append(Solid(bool(bodies.solid_inner[p]), first, bodies.planes[first:last].tolist()))
    return solids


def pose_at(pose, velocity, acceleration, yaw_rate, tau):
    """Return x, y [m], yaw [rad] at a time offset, with constant acceleration and yaw rate."""
    x = pose[0] + velocity[0] * tau + acceleration[0] * tau**2 / 2
    y = pose[1] + velocity[1] * tau + acceleration[1] * tau**2 / 2
    return float(x), float(y), float(pose[2] + yaw_rate * tau)


def all_hits(ray, scene):
    """Return the hit of a ray on each body, each wall and the ground, each as if it were alone; None without a hit.

    A solid around the ray's origin is not hit, and an inner solid only through a pane.
    """
    hits = [hit_body(ray, scene, a) for a in range(len(scene.poses))]
    hits += [_hit_wall(ray, w, *wall) for w, wall in enumerate(scene.walls)]
    return [*hits, _hit_ground(ray)]


def nearest(hits):
    return min((one for one in hits if one), key=lambda one: one.range, default=None)


def hit_body(ray, scene, a, *, inner=False, beyond=0.0):
    """Return the nearest hit beyond a range on the outer, or the inner, solids of a body."""
    local = _into(scene.poses[a], ray)
    hits = [_hit_solid(local, a, solid) for solid in scene.solids[a] if solid.inner == inner]
    return nearest([one for one in hits if one and one.range > beyond])


def _into(pose, ray):
    """Transform a ray to the frame of a pose."""
    x, y, yaw = pose
    cos, sin = math.cos(yaw), math.sin(yaw)
    (px, py, pz), (dx, dy, dz) = ray
    px, py = px - x, py - y
    return Ray((cos * px + sin * py, cos * py - sin * px, pz), (cos * dx + sin * dy, cos * dy - sin * dx, dz))


def _hit_solid(ray, body, solid):
    """Slab method: a ray is in a convex solid from its last entry plane to its first exit plane."""
    (x, y, z), (dx, dy, dz) = ray
    enter, leave, surface, cosine = 0.0, math.inf, None, 0.0
    for row, (nx, ny, nz, offset) in enumerate(solid.planes, solid.first):
        rate = nx * dx + ny * dy + nz * dz
        outside = nx * x + ny * y + nz * z - offset
        if rate == 0.0:
            if outside > 0.0:
                return None
        elif rate > 0.0:
            leave = min(leave, -outside / rate)
        elif -outside / rate > enter:
            enter, surface, cosine = -outside / rate, row, -rate
        if enter >= leave:
            return None
    return None if surface is None else Hit(enter, body, surface, cosine)


def _hit_wall(ray, w, x1, y1, x2, y2, low, high):
    """Hit on a two-sided vertical rectangle between two ends and two heights.

    On the wall, origin + reach * direction = end + share * (other end - end).
    """
    (ox, oy, oz), (dx, dy, dz) = ray
    side_x, side_y = x2 - x1, y2 - y1
    facing = dx * side_y - dy * side_x
    if facing == 0.0:
        return None
    reach = ((x1 - ox) * side_y - (y1 - oy) * side_x) / facing
    share = ((x1 - ox) * dy - (y1 - oy) * dx) / facing
    if reach > 0.0 and 0.0 <= share <= 1.0 and low <= oz + reach * dz <= high:
        return Hit(reach, WALL, w, abs(facing) / math.hypot(side_x, side_y))
    return None


def _hit_ground(ray):
    height, down = ray.origin[2], -ray.direction[2]
    return Hit(height / down, GROUND, 0, down) if height > 0.0 and down > 0.0 else None


def perturbed(bodies, walls, seed, size=1e-9):
    """Return the bodies and walls with every plane, end and height shifted at random, by at most `size` [m].

    Rounding decides the hit of a ray that grazes an edge or hits coincident surfaces. In these cases the result of the
    reference implementation changes, too, under shifts of a nanometre.
    """
    rng = np.random.default_rng(seed)
    planes = bodies.planes.copy()
    planes[:, 3] += rng.uniform(-size, size, len(planes))
    ends, z = (array + rng.uniform(-size, size, array.shape) for array in (walls.ends, walls.z))
    return replace(bodies, planes=planes), replace(walls, ends=ends, z=z)


def philox4x32(counter, key):
    """Return four words of Philox4x32-10, by the definition in Salmon et al. (SC 2011)."""
    c, k = list(counter), list(key)
    for _ in range(10):
        high0, low0 = divmod(0xD2511F53 * c[0], 1 << 32)
        high1, low1 = divmod(0xCD9E8D57 * c[2], 1 << 32)
        c = [high1 ^ c[1] ^ k[0], low1, high0 ^ c[3] ^ k[1], low0]
        k = [(k[0] + 0x9E3779B9) & _MASK, (k[1] + 0xBB67AE85) & _MASK]
    return c

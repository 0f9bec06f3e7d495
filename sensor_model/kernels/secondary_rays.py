"""Single rays, each from its own place at its own time."""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Bools, Floats, Ints
from sensor_model.kernels.motion import body_at
from sensor_model.kernels.rays import NONE
from sensor_model.kernels.records import Solids, StaticScene

_SLACK = 1e-9  # rounding must not lose a ray that just grazes a thing


@njit(cache=True)
def cast_rays(
    origin: Floats, direction: Floats, time: Floats, reach: Floats, bodies: Solids, around: StaticScene
) -> tuple[Floats, Floats, Floats]:
    """Cast single rays from origins (G, 3) along directions (G, 3), each at its time (G,) and as far as its reach (G,).

    Returns
    -------
    (G,) range, infinite where a ray meets nothing; reflectivity of what it meets, and cosine of the angle of incidence.
    """
    nearest, reflectivity, cosine = reach.copy(), np.zeros(len(time)), np.zeros(len(time))
    _meet_ground(origin, direction, around.ground_reflectivity, nearest, reflectivity, cosine)
    _meet_walls(origin, direction, around.ends, around.z, around.reflectivity, nearest, reflectivity, cosine)
    _meet_bodies(
        origin, direction, time, bodies.motion, bodies.bounds, bodies.body_solid, bodies.solid_plane,
        bodies.solid_bounds, bodies.solid_inner, bodies.planes, bodies.reflectivity, nearest, reflectivity, cosine,
    )  # fmt: skip
    for g in range(len(time)):
        if nearest[g] == reach[g]:
            nearest[g] = math.inf
    return nearest, reflectivity, cosine


@njit(cache=True, error_model="numpy")
def _meet_ground(
    origin: Floats, direction: Floats, ground: float, nearest: Floats, reflectivity: Floats, cosine: Floats
) -> None:
    """Shorten the rays that meet the plane z = 0."""
    for g in range(len(nearest)):
        t = -origin[g, 2] / direction[g, 2]
        if direction[g, 2] < 0.0 and t < nearest[g]:
            nearest[g], reflectivity[g], cosine[g] = t, ground, -direction[g, 2]


@njit(cache=True, error_model="numpy")
def _meet_walls(
    origin: Floats, direction: Floats, ends: Floats, z: Floats, wall_reflectivity: Floats,
    nearest: Floats, reflectivity: Floats, cosine: Floats,
) -> None:  # fmt: skip
    """Shorten the rays that meet walls."""
    for w in range(len(ends)):
        ex, ey = ends[w, 2] - ends[w, 0], ends[w, 3] - ends[w, 1]
        length = math.sqrt(ex * ex + ey * ey)
        ex, ey = ex / length, ey / length
        for g in range(len(nearest)):
            gx, gy, dx, dy = ends[w, 0] - origin[g, 0], ends[w, 1] - origin[g, 1], direction[g, 0], direction[g, 1]
            towards = dx * ey - dy * ex
            t = (gx * ey - gy * ex) / towards
            along, height = (t * dx - gx) * ex + (t * dy - gy) * ey, origin[g, 2] + t * direction[g, 2]
            if 0.0 < t < nearest[g] and 0.0 <= along <= length and z[w, 0] <= height <= z[w, 1]:
                nearest[g], reflectivity[g], cosine[g] = t, wall_reflectivity[w], abs(towards)


@njit(cache=True, error_model="numpy")
def _meet_bodies(
    origin: Floats, direction: Floats, time: Floats, motion: Floats, bounds: Floats, body_solid: Ints,
    solid_plane: Ints, solid_bounds: Floats, solid_inner: Bools, planes: Floats, plane_reflectivity: Floats,
    nearest: Floats, reflectivity: Floats, cosine: Floats,
) -> None:  # fmt: skip
    """Shorten the rays that enter the outer solids of bodies; first come the circles around both, in plan."""
    for a in range(len(motion)):
        front, side = max(-bounds[a, 0, 0], bounds[a, 1, 0]), max(-bounds[a, 0, 1], bounds[a, 1, 1])
        around_body = front * front + side * side
        for g in range(len(time)):
            dx, dy = direction[g, 0], direction[g, 1]
            body_x, body_y = body_at(motion, a, time[g])
            x, y = origin[g, 0] - body_x, origin[g, 1] - body_y
            if _passes(-x, -y, dx, dy, around_body, nearest[g]):
                continue
            yaw = motion[a, 2] + motion[a, 7] * time[g]
            cos, sin = math.cos(yaw), math.sin(yaw)
            x, y, z = cos * x + sin * y, cos * y - sin * x, origin[g, 2]
            dx, dy, dz = cos * dx + sin * dy, cos * dy - sin * dx, direction[g, 2]
            for p in range(body_solid[a], body_solid[a + 1]):
                front, side = 0.5 * solid_bounds[p, 1, 0], 0.5 * solid_bounds[p, 1, 1]
                rear, other = 0.5 * solid_bounds[p, 0, 0], 0.5 * solid_bounds[p, 0, 1]
                around_solid = (front - rear) * (front - rear) + (side - other) * (side - other)
                if solid_inner[p] or _passes(front + rear - x, side + other - y, dx, dy, around_solid, nearest[g]):
                    continue
                enter, plane, towards = _entry(
                    planes, solid_plane[p], solid_plane[p + 1], x, y, z, dx, dy, dz, nearest[g]
                )
                if plane != NONE:
                    nearest[g], reflectivity[g], cosine[g] = enter, plane_reflectivity[plane], towards


@njit(cache=True, error_model="numpy")
def _entry(
    planes: Floats, begin: int, stop: int, x: float, y: float, z: float, dx: float, dy: float, dz: float, limit: float
) -> tuple[float, int, float]:
    """Where a ray enters the convex solid of planes [begin, stop): range, plane, cosine of incidence; else no plane."""
    enter, leave, plane, towards = -math.inf, limit, NONE, 0.0
    for q in range(begin, stop):
        inward = planes[q, 3] - planes[q, 0] * x - planes[q, 1] * y - planes[q, 2] * z
        along = planes[q, 0] * dx + planes[q, 1] * dy + planes[q, 2] * dz
        if inward < 0.0:  # outside: the ray must come in here
            at = inward / along if along < 0.0 else math.inf
            if at > enter:
                enter, plane, towards = at, q, -along
        elif along > 0.0:
            leave = min(leave, inward / along)
        if enter >= leave:
            return limit, NONE, 0.0
    return enter, plane, towards


@njit(cache=True)
def _passes(x: float, y: float, dx: float, dy: float, radius_squared: float, limit: float) -> bool:
    """Whether a ray from the origin, followed up to a limit, stays out of a circle around (x, y) in plan."""
    across, ahead, plan_squared = dx * y - dy * x, dx * x + dy * y, dx * dx + dy * dy
    wide, beyond = radius_squared * plan_squared + _SLACK, ahead - limit * plan_squared
    return across * across > wide or (ahead < 0.0 and ahead * ahead > wide) or (beyond > 0.0 and beyond * beyond > wide)

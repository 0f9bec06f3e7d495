"""Single rays, each with its own origin and firing time."""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.ground_hits import terrain_hit
from luxloop.sensor_model.kernels.motion import body_at
from luxloop.sensor_model.kernels.records import NONE, Solids, StaticScene

_SLACK = 1e-9  # tolerance for rounding, so that no grazing ray is culled


@kernel()
def cast_rays(
    origin: Floats, direction: Floats, time: Floats, reach: Floats, bodies: Solids, static: StaticScene
) -> tuple[Floats, Floats, Floats]:
    """Cast G single rays.

    Parameters
    ----------
    origin, direction, time, reach
        (G, 3), (G, 3) in the ego frame [m]; (G,) firing time relative to the frame's [s]; (G,) maximum range [m].

    Returns
    -------
    (G,) range, infinite without a hit [m]; reflectivity of the surface hit; cosine of the angle of incidence.
    """
    nearest, reflectivity, cosine = reach.copy(), np.zeros(len(time)), np.zeros(len(time))
    if len(static.ground.height) == 0:
        _intersect_ground(origin, direction, static.ground_reflectivity, nearest, reflectivity, cosine)
    else:
        _intersect_terrain(origin, direction, static, nearest, reflectivity, cosine)
    _intersect_walls(origin, direction, static.ends, static.z, static.reflectivity, nearest, reflectivity, cosine)
    _intersect_bodies(origin, direction, time, bodies, nearest, reflectivity, cosine)
    for g in range(len(time)):
        if nearest[g] == reach[g]:
            nearest[g] = math.inf
    return nearest, reflectivity, cosine


@kernel(error_model="numpy")
def _intersect_ground(
    origin: Floats, direction: Floats, ground: float, nearest: Floats, reflectivity: Floats, cosine: Floats
) -> None:
    """End the rays on the plane z = 0 where it is nearer than their hits so far."""
    for g in range(len(nearest)):
        t = -origin[g, 2] / direction[g, 2]
        if direction[g, 2] < 0.0 and t < nearest[g]:
            nearest[g], reflectivity[g], cosine[g] = t, ground, -direction[g, 2]


@kernel(error_model="numpy")
def _intersect_terrain(
    origin: Floats, direction: Floats, static: StaticScene, nearest: Floats, reflectivity: Floats, cosine: Floats
) -> None:
    """End the rays on uneven ground where it is nearer than their hits so far."""
    for g in range(len(nearest)):
        start = origin[g, 0], origin[g, 1], origin[g, 2]
        along = direction[g, 0], direction[g, 1], direction[g, 2]
        t, facing = terrain_hit(start, along, nearest[g], static.ground)
        if t < nearest[g]:
            nearest[g], reflectivity[g], cosine[g] = t, static.ground_reflectivity, facing


@kernel(error_model="numpy")
def _intersect_walls(
    origin: Floats, direction: Floats, ends: Floats, z: Floats, wall_reflectivity: Floats,
    nearest: Floats, reflectivity: Floats, cosine: Floats,
) -> None:  # fmt: skip
    """End the rays on walls nearer than their hits so far."""
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


@kernel(error_model="numpy")
def _intersect_bodies(
    origin: Floats, direction: Floats, time: Floats, bodies: Solids, nearest: Floats, reflectivity: Floats,
    cosine: Floats,
) -> None:  # fmt: skip
    """End the rays on outer solids of bodies; circles around bodies and solids in plan cull most rays before."""
    # Unpacked once: each access to a record's array costs an atomic reference count.
    motion, bounds, body_solid, solid_plane = bodies.motion, bodies.bounds, bodies.body_solid, bodies.solid_plane
    solid_bounds, solid_inner, planes = bodies.solid_bounds, bodies.solid_inner, bodies.planes
    plane_reflectivity = bodies.reflectivity
    for a in range(len(motion)):
        front, side = max(-bounds[a, 0, 0], bounds[a, 1, 0]), max(-bounds[a, 0, 1], bounds[a, 1, 1])
        around_body = front * front + side * side
        for g in range(len(time)):
            dx, dy = direction[g, 0], direction[g, 1]
            body_x, body_y = body_at(motion, a, time[g])
            x, y = origin[g, 0] - body_x, origin[g, 1] - body_y
            if _misses_circle(-x, -y, dx, dy, around_body, nearest[g]):
                continue
            yaw = motion[a, 2] + motion[a, 7] * time[g]
            cos, sin = elementary.cos(yaw), elementary.sin(yaw)
            x, y, z = cos * x + sin * y, cos * y - sin * x, origin[g, 2]
            dx, dy, dz = cos * dx + sin * dy, cos * dy - sin * dx, direction[g, 2]
            for p in range(body_solid[a], body_solid[a + 1]):
                front, side = 0.5 * solid_bounds[p, 1, 0], 0.5 * solid_bounds[p, 1, 1]
                rear, other = 0.5 * solid_bounds[p, 0, 0], 0.5 * solid_bounds[p, 0, 1]
                around_solid = (front - rear) * (front - rear) + (side - other) * (side - other)
                if solid_inner[p] or _misses_circle(
                    front + rear - x, side + other - y, dx, dy, around_solid, nearest[g]
                ):
                    continue
                enter, plane, towards = _entry(
                    planes, solid_plane[p], solid_plane[p + 1], x, y, z, dx, dy, dz, nearest[g]
                )
                if plane != NONE:
                    nearest[g], reflectivity[g], cosine[g] = enter, plane_reflectivity[plane], towards


@kernel(error_model="numpy")
def _entry(
    planes: Floats, begin: int, stop: int, x: float, y: float, z: float, dx: float, dy: float, dz: float, limit: float
) -> tuple[float, int, float]:
    """Return range, plane and cosine of incidence at which a ray enters the convex solid of planes [begin, stop).

    The plane is NONE if the ray does not enter the solid before `limit`.
    """
    enter, leave, plane, towards = -math.inf, limit, NONE, 0.0
    for q in range(begin, stop):
        inward = planes[q, 3] - planes[q, 0] * x - planes[q, 1] * y - planes[q, 2] * z
        along = planes[q, 0] * dx + planes[q, 1] * dy + planes[q, 2] * dz
        if inward < 0.0:  # outside: the ray can only enter through this plane
            at = inward / along if along < 0.0 else math.inf
            if at > enter:
                enter, plane, towards = at, q, -along
        elif along > 0.0:
            leave = min(leave, inward / along)
        if enter >= leave:
            return limit, NONE, 0.0
    return enter, plane, towards


@kernel()
def _misses_circle(x: float, y: float, dx: float, dy: float, radius_squared: float, limit: float) -> bool:
    """Return True if a ray from the origin, up to a limit, stays outside a circle around (x, y) in plan."""
    across, ahead, plan_squared = dx * y - dy * x, dx * x + dy * y, dx * dx + dy * dy
    wide, beyond = radius_squared * plan_squared + _SLACK, ahead - limit * plan_squared
    return across * across > wide or (ahead < 0.0 and ahead * ahead > wide) or (beyond > 0.0 and beyond * beyond > wide)

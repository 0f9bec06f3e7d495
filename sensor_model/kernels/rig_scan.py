"""Scan of a whole rig, fan by fan."""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels.culling import azimuths_in_fan, body_intervals, wall_intervals
from sensor_model.kernels.rays import aim_rays, intersect_ground, intersect_walls
from sensor_model.kernels.receiver import receive_fan
from sensor_model.kernels.records import (
    INVERSE_DEPTH,
    TARGET,
    Beams,
    EgoDrive,
    Fans,
    Grid,
    Rays,
    ScanBuffers,
    Solids,
    StaticScene,
    Units,
)
from sensor_model.kernels.solid_hits import intersect_bodies
from sensor_model.returns import NOTHING


@njit(cache=True)
def cast_rig(
    fans: Fans, grid: Grid, beams: Beams, units: Units, bodies: Solids, static: StaticScene, drive: EgoDrive,
    frame: int, out: ScanBuffers,
) -> None:  # fmt: skip
    """Cast all beams of the rig once.

    Parameters
    ----------
    frame
        Index of the frame, which decides the fans that fire.
    out
        Echoes, lost beams, free ranges and hits; counts start at 0.
    """
    unit = -1
    body_interval, wall_interval = np.empty((len(bodies.motion), 2)), np.empty((len(static.ends), 2))
    body_rows = np.empty((3 * len(bodies.motion), 3), np.int64)
    wall_rows = np.empty((3 * len(static.ends), 3), np.int64)
    for f in range(len(fans.fan_unit)):
        if frame % fans.fan_turn[f, 1] != fans.fan_turn[f, 0]:
            continue
        u = fans.fan_unit[f]
        origin, rotation, reach, half_width = units.origin[u], units.rotation[u], units.range_max[u], grid.half_width[u]
        if u != unit:
            unit, time_max = u, _max_firing_time(fans, u, beams.time)
            body_intervals(
                bodies.motion, bodies.bounds, origin, rotation, reach, half_width, time_max, drive, body_interval
            )
            wall_intervals(static.ends, static.z, origin, rotation, reach, half_width, time_max, drive, wall_interval)
        first_beam = fans.row_beam[fans.fan_row[f] : fans.fan_row[f + 1]]
        azimuths = fans.row_beam[fans.fan_row[f] + 1] - first_beam[0]
        time = beams.time[first_beam[0] : first_beam[0] + azimuths]
        start, step = fans.fan_azimuth[f, 0], fans.fan_azimuth[f, 1]

        rays = aim_rays(grid, f, time, origin, rotation, drive)
        intersect_ground(rays)
        used = azimuths_in_fan(wall_interval, start, step, azimuths, wall_rows)
        intersect_walls(wall_rows[:used], grid.rays_wide, rays, static)
        used = azimuths_in_fan(body_interval, start, step, azimuths, body_rows)
        intersect_bodies(body_rows[:used], grid.rays_wide, time, rays, bodies, out.unit_hits_alone[u])
        _count_hits(rays.hit_id[TARGET], out.unit_hits[u])
        if len(out.free_range) > 0:
            _set_free_range(first_beam, grid.rays_wide, rays, out.free_range)
        receive_fan(u, first_beam, beams, units, bodies, static, grid.rays_wide, rays, out)


@njit(cache=True)
def _max_firing_time(fans: Fans, u: int, time: Floats) -> float:
    """Return the largest time between the firing of a beam of unit u and the frame's time [s]."""
    longest = 0.0
    for f in range(len(fans.fan_unit)):
        if fans.fan_unit[f] == u:
            first, end = fans.row_beam[fans.fan_row[f]], fans.row_beam[fans.fan_row[f + 1]]
            longest = max(longest, abs(time[first]), abs(time[end - 1]))
    return longest


@njit(cache=True)
def _count_hits(target: Ints, hits: Ints) -> None:
    """Count the rays that end on each body."""
    for m in range(len(target)):
        for i in range(target.shape[1]):
            if target[m, i] >= 0:
                hits[target[m, i]] += 1


@njit(cache=True, error_model="numpy")
def _set_free_range(first_beam: Ints, rays_wide: int, rays: Rays, free_range: Floats) -> None:
    """Set the unobstructed range of each beam: that of its farthest ray, infinite if a ray hits nothing."""
    inverse_depth, target, cos = rays.hit[INVERSE_DEPTH], rays.hit_id[TARGET], rays.cos
    rays_high = inverse_depth.shape[1] // len(first_beam)
    for layer in range(len(first_beam)):
        for k in range(len(inverse_depth) // rays_wide):
            farthest = 0.0
            for m in range(k * rays_wide, (k + 1) * rays_wide):
                for i in range(layer * rays_high, (layer + 1) * rays_high):
                    r = math.inf if target[m, i] == NOTHING else 1.0 / (inverse_depth[m, i] * cos[m, i])
                    farthest = max(farthest, r)
            free_range[first_beam[layer] + k] = farthest

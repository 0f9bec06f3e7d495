"""Scan of a whole rig: fan by fan, in blocks of azimuths."""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.culling import azimuths_in_fan, body_intervals, wall_intervals
from luxloop.sensor_model.kernels.ground_hits import intersect_terrain
from luxloop.sensor_model.kernels.rays import aim_rays, intersect_ground
from luxloop.sensor_model.kernels.receiver import receive_block
from luxloop.sensor_model.kernels.records import (
    BEAM,
    INVERSE_DEPTH,
    SURFACE,
    TARGET,
    Beams,
    DenseEchoes,
    EgoDrive,
    Fans,
    Grid,
    Rays,
    ScanBuffers,
    Solids,
    StaticScene,
    Units,
)
from luxloop.sensor_model.kernels.solid_hits import intersect_bodies
from luxloop.sensor_model.kernels.wall_hits import intersect_walls
from luxloop.sensor_model.returns import NOTHING

_BLOCK = 2048  # rays that are cast together, so that their state stays in the cache


@kernel()
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
        Echoes, lost beams, free ranges and hits; counts start at 0, and no beam is lost.
    """
    unit, uneven = -1, len(static.ground.height) > 0
    body_interval, wall_interval = np.empty((len(bodies.motion), 2)), np.empty((len(static.ends), 2))
    rows = np.empty((3 * max(len(bodies.motion), len(static.ends)), 3), np.int64)
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
        step = fans.fan_azimuth[f, 1]
        block_azimuths = max(1, _BLOCK // (len(first_beam) * grid.side.shape[2]))
        for first in range(0, azimuths, block_azimuths):
            count = min(block_azimuths, azimuths - first)
            block = slice(first_beam[0] + first, first_beam[0] + first + count)
            time, start = beams.time[block], fans.fan_azimuth[f, 0] + first * step
            rays = aim_rays(
                grid, f, first, len(first_beam), grid.azimuth[block], time, u, origin, rotation, drive, uneven
            )
            if uneven:
                intersect_terrain(rays, static.ground)
            else:
                intersect_ground(rays)
            used = azimuths_in_fan(wall_interval, start, step, count, rows)
            intersect_walls(rows[:used], grid.refine, rays, static)
            used = azimuths_in_fan(body_interval, start, step, count, rows)
            _sort_near_to_far(rows[:used], bodies.motion, origin)
            intersect_bodies(rows[:used], half_width, grid.refine, time, rays, bodies, out.unit_hits_alone[u])
            if len(out.free_range) > 0:
                _set_free_range(first_beam, first, rays, out.free_range)
            receive_block(u, first_beam, first, beams, units, bodies, static, rays, out)


@kernel()
def _sort_near_to_far(rows: Ints, motion: Floats, origin: Floats) -> None:
    """Sort the rows of bodies by the distance of their bodies from a unit, so that near ones hide far ones early."""
    for end in range(1, len(rows)):  # insertion sort: few rows, and numpy's sort takes seconds to compile
        a, first, stop = rows[end, 0], rows[end, 1], rows[end, 2]
        distance, row = elementary.hypot(motion[a, 0] - origin[0], motion[a, 1] - origin[1]), end
        while row > 0:
            before = rows[row - 1, 0]
            if elementary.hypot(motion[before, 0] - origin[0], motion[before, 1] - origin[1]) <= distance:
                break
            for column in range(3):
                rows[row, column] = rows[row - 1, column]
            row -= 1
        rows[row, 0], rows[row, 1], rows[row, 2] = a, first, stop


@kernel()
def _max_firing_time(fans: Fans, u: int, time: Floats) -> float:
    """Return the largest time between the firing of a beam of unit u and the frame's time [s]."""
    longest = 0.0
    for f in range(len(fans.fan_unit)):
        if fans.fan_unit[f] == u:
            first, end = fans.row_beam[fans.fan_row[f]], fans.row_beam[fans.fan_row[f + 1]]
            longest = max(longest, abs(time[first]), abs(time[end - 1]))
    return longest


@kernel(error_model="numpy")
def _set_free_range(first_beam: Ints, first: int, rays: Rays, free_range: Floats) -> None:
    """Set the unobstructed range of each beam: that of its farthest ray, infinite if a ray hits nothing."""
    inverse_depth, target, cos = rays.hit[INVERSE_DEPTH], rays.hit_id[TARGET], rays.cos
    for layer in range(len(first_beam)):
        for k in range(len(inverse_depth)):
            farthest = 0.0
            for r in range(cos.shape[2]):
                hits = target[k, layer, r] != NOTHING
                at = 1.0 / (inverse_depth[k, layer, r] * cos[k, layer, r]) if hits else math.inf
                farthest = max(farthest, at)
            free_range[first_beam[layer] + first + k] = farthest


@kernel()
def pack_echoes(out: ScanBuffers) -> DenseEchoes:
    """Return the echoes and the lost beams without the empty slots."""
    found, lost = 0, 0
    for b in range(len(out.lost)):
        found += out.echoes[b]
        lost += out.lost[b]
    dense = DenseEchoes(
        np.empty((3, found)), np.empty((3, found), np.int64), np.empty(lost, np.int64), np.empty((2, lost))
    )
    echo, echo_id, lost_beam, lost_echo = dense
    n, m = 0, 0
    for b in range(len(out.echoes)):
        for e in range(out.echoes[b]):
            for row in range(3):
                echo[row, n] = out.echo[row, b, e]
            echo_id[TARGET, n], echo_id[SURFACE, n] = out.echo_id[TARGET, b, e], out.echo_id[SURFACE, b, e]
            echo_id[BEAM, n] = b
            n += 1
        if out.lost[b]:
            lost_beam[m], lost_echo[0, m], lost_echo[1, m] = b, out.lost_echo[0, b], out.lost_echo[1, b]
            m += 1
    return dense

"""All beams of a rig against the world: the sweep, fan by fan."""

import math

import numpy as np
from numba import njit

from sensor_model.arrays import Floats, Ints
from sensor_model.kernels import rays as ray
from sensor_model.kernels.culling import azimuths_in, bodies_in_sight, walls_in_sight
from sensor_model.kernels.receiver import listen
from sensor_model.kernels.records import Beams, EgoDrive, Fans, Grid, Solids, StaticScene, Units
from sensor_model.kernels.solid_hits import meet_bodies
from sensor_model.returns import NOTHING


@njit(cache=True)
def cast_rig(
    fans: Fans, grid: Grid, beams: Beams, units: Units, bodies: Solids, around: StaticScene, drive: EgoDrive, frame: int,
    echo: Floats, echo_id: Ints, lost_beam: Ints, lost_echo: Floats, free_range: Floats,
    unit_hits: Ints, unit_hits_alone: Ints,
) -> tuple[int, int]:  # fmt: skip
    """Sweep the rig once.

    Parameters
    ----------
    frame
        Number of the frame, which decides which fans fire.
    echo, echo_id
        Out: echoes in the order of the beams; rows as in `kernels.echoes`.
    lost_beam, lost_echo
        Out: beams that met something and have no echo; the most that came back at once, and from where (range, power).
    free_range
        (B,) in and out: how far each beam's rays get, or (0,) if nobody asks.
    unit_hits, unit_hits_alone
        (U, A) in and out: rays that end on each body, and that would if it were alone on the ground.

    Returns
    -------
    How many echoes there are, and how many lost beams.
    """
    found, lost, unit = 0, 0, -1
    body_interval, wall_interval = np.empty((len(bodies.motion), 2)), np.empty((len(around.ends), 2))
    body_rows = np.empty((3 * len(bodies.motion), 3), np.int64)
    wall_rows = np.empty((3 * len(around.ends), 3), np.int64)
    for f in range(len(fans.fan_unit)):
        if frame % fans.fan_turn[f, 1] != fans.fan_turn[f, 0]:
            continue
        u = fans.fan_unit[f]
        origin, rotation, reach, half_width = units.origin[u], units.rotation[u], units.range_max[u], grid.half_width[u]
        if u != unit:
            unit, longest = u, _longest(fans, u, beams.time)
            bodies_in_sight(
                bodies.motion, bodies.bounds, origin, rotation, reach, half_width, longest, drive, body_interval
            )
            walls_in_sight(around.ends, around.z, origin, rotation, reach, half_width, longest, drive, wall_interval)
        beam = fans.row_beam[fans.fan_row[f] : fans.fan_row[f + 1]]  # the first of each layer
        azimuths = fans.row_beam[fans.fan_row[f] + 1] - beam[0]
        time = beams.time[beam[0] : beam[0] + azimuths]
        start, step = fans.fan_azimuth[f, 0], fans.fan_azimuth[f, 1]

        rays = ray.aimed(grid, f, time, origin, rotation, drive)
        ray.meet_ground(rays.column, rays.slope, rays.far, rays.nearness, rays.target, rays.inner_surface)
        used = azimuths_in(wall_interval, start, step, azimuths, wall_rows)
        ray.meet_walls(wall_rows[:used], grid.turns, rays, around)
        used = azimuths_in(body_interval, start, step, azimuths, body_rows)
        meet_bodies(body_rows[:used], grid.turns, time, rays, bodies, unit_hits_alone[u])
        _count(rays.target, unit_hits[u])
        if len(free_range) > 0:
            _free(beam, grid.turns, rays.nearness, rays.cos, rays.target, free_range)
        found, lost = listen(
            u, beam, beams, units, bodies, around, grid.turns, rays,
            echo, echo_id, found, lost_beam, lost_echo, lost,
        )  # fmt: skip
    return found, lost


@njit(cache=True)
def _longest(fans: Fans, u: int, time: Floats) -> float:
    """How long before or after the frame's time a beam of unit u fires, at most."""
    longest = 0.0
    for f in range(len(fans.fan_unit)):
        if fans.fan_unit[f] == u:
            first, end = fans.row_beam[fans.fan_row[f]], fans.row_beam[fans.fan_row[f + 1]]
            longest = max(longest, abs(time[first]), abs(time[end - 1]))
    return longest


@njit(cache=True)
def _count(target: Ints, hits: Ints) -> None:
    """Count the rays that end on each body."""
    for m in range(len(target)):
        for i in range(target.shape[1]):
            if target[m, i] >= 0:
                hits[target[m, i]] += 1


@njit(cache=True, error_model="numpy")
def _free(beam: Ints, turns: int, nearness: Floats, cos: Floats, target: Ints, free_range: Floats) -> None:
    """Set how far the beams of a fan get: as far as the farthest of their rays, infinitely if one meets nothing."""
    rises = nearness.shape[1] // len(beam)
    for layer in range(len(beam)):
        for k in range(len(nearness) // turns):
            farthest = 0.0
            for m in range(k * turns, (k + 1) * turns):
                for i in range(layer * rises, (layer + 1) * rises):
                    r = math.inf if target[m, i] == NOTHING else 1.0 / (nearness[m, i] * cos[m, i])
                    farthest = max(farthest, r)
            free_range[beam[layer] + k] = farthest

"""Slow and obvious twin of the sensor's optics: sub-rays, the power they return, and the echoes made of it.

Written from the description of the model alone: one beam at a time, sums by definition.
"""

import math
from typing import NamedTuple

import numpy as np
from support.naive_caster import Ray, everything, meet_body, nearest, pose_at, scene_at

from sensor_model.raycaster import GROUND_REFLECTIVITY
from sensor_model.returns import GROUND, WALL


class Back(NamedTuple):
    """What one sub-ray brings back from one surface."""

    range: float
    power: float
    target: int
    surface: int


class Run(NamedTuple):
    """A stretch of ranges over which the summed power is at least the threshold."""

    start: float
    end: float
    peak: float


class Echo(NamedTuple):
    range: float
    width: float
    power: float
    target: int
    surface: int


class BeamAnswer(NamedTuple):
    met: bool
    """Whether it met anything, however near."""
    peak: float
    """Highest power [1/m^2]."""
    echoes: list[Echo]
    hits: list[int]
    """Sub-rays that end on each body."""
    hits_alone: list[int]
    """Sub-rays that would, were it alone on the ground."""


def answer(beams, sensor, bodies, walls, setting, b):
    """All that one beam of the table tells; None if its fan has not its turn in this frame."""
    if not has_turn(beams, setting.frame_index, b):
        return None
    unit = int(beams.unit[b])
    tau = float((beams.time_offset[b] if sensor.sweep else 0.0) + setting.time_jitter[unit])
    scene = scene_at(bodies, walls, tau)
    rays = sub_rays(beams, sensor, setting, b, tau)
    met = [everything(ray, scene) for ray in rays]
    first = [within(nearest(one), beams, unit) for one in met]
    backs = []
    for ray, surface in zip(rays, first, strict=True):
        if surface and surface.range >= beams.units.range_min[unit]:
            backs += powers(ray, surface, scene, beams, bodies, walls, setting, b, len(rays))
    return BeamAnswer(
        met=any(first),
        peak=peak_power(backs, float(beams.units.pulse_length[unit])),
        echoes=echoes_of(backs, beams.units, unit, float(setting.threshold[b])),
        hits=[sum(surface is not None and surface.target == a for surface in first) for a in range(len(bodies))],
        hits_alone=[sum(ends_on(one, a, beams, unit) for one in met) for a in range(len(bodies))],
    )


def ends_on(met, a, beams, unit):
    """Whether a ray ends on a body that is alone on the ground."""
    end = within(nearest([met[a], met[-1]]), beams, unit)
    return end is not None and end.target == a


def has_turn(beams, frame_index, b):
    row = np.searchsorted(beams.row_beam, b, side="right") - 1
    fan = np.searchsorted(beams.fan_row, row, side="right") - 1
    turn, turns = beams.fan_turn[fan]
    return frame_index % turns == turn


def within(met, beams, unit):
    return met if met and met.range <= beams.units.range_max[unit] else None


def sub_rays(beams, sensor, setting, b, tau):
    """Midpoints of an even grid over the beam's height and width, as angles about its centre."""
    rows, columns = sensor.footprint
    unit = beams.unit[b]
    height, width = beams.units.beam_height[unit], beams.units.beam_width[unit]
    rays = []
    for i in range(rows):
        for j in range(columns):
            up, left = ((i + 0.5) / rows - 0.5) * height, ((j + 0.5) / columns - 0.5) * width
            rays.append(ray_at(beams, setting, b, tau, up, left))
    return rays


def ray_at(beams, setting, b, tau, up, left):
    """A ray of a unit at a time offset: the ego has moved and turned by then, and its units with it."""
    azimuth, elevation = beams.azimuth[b] + left, beams.elevation[b] + up
    flat = math.cos(elevation)
    direction_unit = np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)])
    x, y, yaw = pose_at((0.0, 0.0, 0.0), setting.ego_velocity, setting.ego_acceleration, setting.ego_yaw_rate, tau)
    turn = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    unit = beams.unit[b]
    origin = turn @ setting.origin_ego[unit] + [x, y, 0.0]
    direction = turn @ setting.R_ego_unit[unit] @ direction_unit
    return Ray(tuple(origin.tolist()), tuple(direction.tolist()))


def powers(ray, first, scene, beams, bodies, walls, setting, b, count):
    """Power of the first surface, and of what a pane lets through and back: rho cos gain exp(-2 alpha r) / (n r^2)."""

    def power(met, share):
        way = math.exp(-2.0 * setting.extinction * met.range)
        return share * met.cosine * float(beams.gain[b]) * way / (count * met.range**2)

    if first.target == GROUND:
        return [Back(first.range, power(first, GROUND_REFLECTIVITY), GROUND, 0)]
    if first.target == WALL:
        return [Back(first.range, power(first, float(walls.reflectivity[first.surface])), WALL, first.surface)]
    backs = [Back(first.range, power(first, float(bodies.plane_reflectivity[first.surface])), *first[1:3])]
    transmission = float(bodies.plane_transmission[first.surface])
    behind = meet_body(ray, scene, first.target, inner=True, beyond=first.range) if transmission > 0.0 else None
    if within(behind, beams, beams.unit[b]):
        reflectivity = transmission * float(bodies.plane_reflectivity[behind.surface])
        backs.append(Back(behind.range, power(behind, reflectivity), *behind[1:3]))
    return backs


def summed(backs, r, pulse):
    """P(r): what a pulse brings back at once. A surface counts from its range on, for one pulse length."""
    return sum(back.power for back in backs if back.range <= r < back.range + pulse)


def steps(backs, pulse):
    """The ranges at which P changes."""
    return sorted({back.range for back in backs} | {back.range + pulse for back in backs})


def peak_power(backs, pulse):
    return max((summed(backs, r, pulse) for r in steps(backs, pulse)), default=0.0)


def echoes_of(backs, units, unit, threshold):
    pulse, growth = float(units.pulse_length[unit]), float(units.pulse_growth[unit])
    runs = merged(runs_of(backs, pulse, threshold), units.echo_separation[unit])
    return [echo_of(run, backs, threshold, growth) for run in runs[: units.echoes_max[unit]]]


def runs_of(backs, pulse, threshold):
    runs = []
    start, peak = None, 0.0
    for r in steps(backs, pulse):
        power = summed(backs, r, pulse)
        if power >= threshold:
            start = r if start is None else start
            peak = max(peak, power)
        elif start is not None:
            runs.append(Run(start, r, peak))
            start, peak = None, 0.0
    return runs


def merged(runs, separation):
    """Runs that start less than the separation after the start of the echo before them belong to it."""
    kept = []
    for run in runs:
        if kept and run.start - kept[-1].start < separation:
            kept[-1] = Run(kept[-1].start, run.end, max(kept[-1].peak, run.peak))
        else:
            kept.append(run)
    return kept


def echo_of(run, backs, threshold, growth):
    """Measure a run: its leading edge, its width, and the surface with most power in its first 10 cm."""
    width = run.end - run.start + growth * 10.0 * math.log10(run.peak / threshold)
    leading = sorted(back for back in backs if run.start <= back.range < run.start + 0.1)
    total = {}
    for back in leading:
        total[back[2:]] = total.get(back[2:], 0.0) + back.power
    target, surface = max(total, key=total.get)  # the first of equals, which is the nearer
    return Echo(run.start, width, run.peak, target, surface)

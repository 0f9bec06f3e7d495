"""Slow reference implementation of the sensor's optics: sub-rays, returned power, and echoes.

It follows the description of the model only: one beam at a time, sums by definition.
"""

import math
from typing import NamedTuple

import numpy as np
from support.naive_caster import Ray, all_hits, hit_body, nearest, pose_at, scene_at

from luxloop.sensor_model.raycaster import GROUND_REFLECTIVITY
from luxloop.sensor_model.returns import GROUND, WALL


class Sample(NamedTuple):
    """Light that one sub-ray returns from one surface."""

    range: float
    power: float
    target: int
    surface: int


class Pulse(NamedTuple):
    """Interval of ranges in which the summed power reaches the threshold."""

    start: float
    end: float
    peak: float


class Echo(NamedTuple):
    range: float
    width: float
    power: float
    target: int
    surface: int


class BeamResult(NamedTuple):
    hit: bool
    """True if the beam hit something, at any range."""
    peak: float
    """Highest power [1/m^2]."""
    echoes: list[Echo]
    hits: list[int]
    """Sub-rays that end on each body."""
    hits_alone: list[int]
    """Sub-rays that would end on each body if it were alone on the ground."""


def beam_result(beams, sensor, bodies, walls, context, b):
    """Return the result of one beam of the table; None if its fan does not fire in this frame."""
    if not fires(beams, context.frame_index, b):
        return None
    unit = int(beams.unit[b])
    tau = float((beams.time_offset[b] if sensor.sweep else 0.0) + context.time_jitter[unit])
    scene = scene_at(bodies, walls, tau)
    rays = sub_rays(beams, sensor, context, b, tau)
    hit = [all_hits(ray, scene) for ray in rays]
    first = [within(nearest(one), beams, unit) for one in hit]
    samples = []
    for ray, surface in zip(rays, first, strict=True):
        if surface and surface.range >= beams.units.range_min[unit]:
            samples += powers(ray, surface, scene, beams, bodies, walls, context, b, len(rays))
    return BeamResult(
        hit=any(first),
        peak=peak_power(samples, float(beams.units.pulse_length[unit])),
        echoes=echoes_of(samples, beams.units, unit, float(context.threshold[b])),
        hits=[sum(surface is not None and surface.target == a for surface in first) for a in range(len(bodies))],
        hits_alone=[sum(ends_on(one, a, beams, unit) for one in hit) for a in range(len(bodies))],
    )


def ends_on(hit, a, beams, unit):
    """Return True if a ray ends on a body that is alone on the ground."""
    end = within(nearest([hit[a], hit[-1]]), beams, unit)
    return end is not None and end.target == a


def fires(beams, frame_index, b):
    row = np.searchsorted(beams.row_beam, b, side="right") - 1
    fan = np.searchsorted(beams.fan_row, row, side="right") - 1
    turn, turns = beams.fan_turn[fan]
    return frame_index % turns == turn


def within(hit, beams, unit):
    return hit if hit and hit.range <= beams.units.range_max[unit] else None


def sub_rays(beams, sensor, context, b, tau):
    """Return the rays through the midpoints of an even grid over the beam's height and width."""
    rows, columns = sensor.footprint
    unit = beams.unit[b]
    height, width = beams.units.beam_height[unit], beams.units.beam_width[unit]
    rays = []
    for i in range(rows):
        for j in range(columns):
            up, left = ((i + 0.5) / rows - 0.5) * height, ((j + 0.5) / columns - 0.5) * width
            rays.append(ray_at(beams, context, b, tau, up, left))
    return rays


def ray_at(beams, context, b, tau, up, left):
    """Return a ray of a unit at a time offset, after the ego with its units has moved and turned."""
    azimuth, elevation = beams.azimuth[b] + left, beams.elevation[b] + up
    flat = math.cos(elevation)
    direction_unit = np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)])
    x, y, yaw = pose_at((0.0, 0.0, 0.0), context.ego_velocity, context.ego_acceleration, context.ego_yaw_rate, tau)
    turn = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    unit = beams.unit[b]
    origin = turn @ context.origin_ego[unit] + [x, y, 0.0]
    direction = turn @ context.R_ego_unit[unit] @ direction_unit
    return Ray(tuple(origin.tolist()), tuple(direction.tolist()))


def powers(ray, first, scene, beams, bodies, walls, context, b, count):
    """Return the samples of the first surface, and behind a pane: rho cos gain exp(-2 alpha r) / (n r^2)."""

    def power(hit, share):
        way = math.exp(-2.0 * context.extinction * hit.range)
        return share * hit.cosine * float(beams.gain[b]) * way / (count * hit.range**2)

    if first.target == GROUND:
        return [Sample(first.range, power(first, GROUND_REFLECTIVITY), GROUND, 0)]
    if first.target == WALL:
        return [Sample(first.range, power(first, float(walls.reflectivity[first.surface])), WALL, first.surface)]
    samples = [Sample(first.range, power(first, float(bodies.plane_reflectivity[first.surface])), *first[1:3])]
    transmission = float(bodies.plane_transmission[first.surface])
    behind = hit_body(ray, scene, first.target, inner=True, beyond=first.range) if transmission > 0.0 else None
    if within(behind, beams, beams.unit[b]):
        reflectivity = transmission * float(bodies.plane_reflectivity[behind.surface])
        samples.append(Sample(behind.range, power(behind, reflectivity), *behind[1:3]))
    return samples


def summed(samples, r, pulse):
    """Return P(r), the power within one pulse: a surface counts from its range on, for one pulse length."""
    return sum(sample.power for sample in samples if sample.range <= r < sample.range + pulse)


def steps(samples, pulse):
    """Return the ranges at which P changes."""
    return sorted({sample.range for sample in samples} | {sample.range + pulse for sample in samples})


def peak_power(samples, pulse):
    return max((summed(samples, r, pulse) for r in steps(samples, pulse)), default=0.0)


def echoes_of(samples, units, unit, threshold):
    pulse, growth = float(units.pulse_length[unit]), float(units.pulse_growth[unit])
    pulses = merged(pulses_of(samples, pulse, threshold), units.echo_separation[unit])
    return [echo_of(interval, samples, threshold, growth) for interval in pulses[: units.echoes_max[unit]]]


def pulses_of(samples, pulse, threshold):
    pulses = []
    start, peak = None, 0.0
    for r in steps(samples, pulse):
        power = summed(samples, r, pulse)
        if power >= threshold:
            start = r if start is None else start
            peak = max(peak, power)
        elif start is not None:
            pulses.append(Pulse(start, r, peak))
            start, peak = None, 0.0
    return pulses


def merged(pulses, separation):
    """Merge intervals that start less than the separation after the start of the previous echo."""
    kept = []
    for interval in pulses:
        if kept and interval.start - kept[-1].start < separation:
            kept[-1] = Pulse(kept[-1].start, interval.end, max(kept[-1].peak, interval.peak))
        else:
            kept.append(interval)
    return kept


def echo_of(interval, samples, threshold, growth):
    """Return the echo of an interval: leading edge, width, and the surface with most power in its first 10 cm."""
    width = interval.end - interval.start + growth * 10.0 * math.log10(interval.peak / threshold)
    leading = sorted(sample for sample in samples if interval.start <= sample.range < interval.start + 0.1)
    total = {}
    for sample in leading:
        total[sample[2:]] = total.get(sample[2:], 0.0) + sample.power
    target, surface = max(total, key=total.get)  # in a tie the first, which is nearer
    return Echo(interval.start, width, interval.peak, target, surface)

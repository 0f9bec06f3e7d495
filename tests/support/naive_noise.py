"""Slow reference implementations of the noise kernels."""

import itertools
import math

import numpy as np
from support.naive_caster import philox4x32


def uniforms(key, *counter):
    """Return two numbers in (0, 1) for a counter of four words."""
    words = philox4x32([int(word) for word in counter], [int(word) for word in key])
    return [(word + 0.5) / 2**32 for word in words[:2]]


def soft_threshold(key, frame, purpose, unit, index, threshold, softness_db, random_rate):
    """Return the threshold of one shot [1/m^2], and True if it is lost at random."""
    p, chance = uniforms(key, frame, unit, index, purpose)
    scale_db = softness_db / (2 * math.log(9))
    p = (math.floor(p * 4096) + 0.5) / 4096
    return threshold * 10 ** (scale_db * math.log(p / (1 - p)) / 10), chance < random_rate


def silent_unit(key, tick, purpose, unit, failing, recovering):
    """Return the state of one unit, computed forward from the start."""
    silent = uniforms(key, 0, unit, 0, purpose)[0] < failing / (failing + recovering)
    for t in range(tick + 1):
        p = uniforms(key, t + 1, unit, 0, purpose)[0]
        silent = p < 1 - recovering if silent else p < failing
        # A silent unit recovers for p above 1 - recovering; a working one fails for p below failing.
    return silent


def rare_beams(key, frame, purpose, unit_beam, rate):
    """Return the randomly selected beams, unit by unit, gap by gap."""
    found = []
    for unit, (first, end) in enumerate(itertools.pairwise(unit_beam.tolist())):
        beam, draw = first, 0
        while True:
            p = uniforms(key, frame, unit, draw, purpose)[0]
            # The smallest gap g with P(gap <= g) = 1 - (1 - rate)^(g + 1) >= 1 - p.
            beam += 0 if rate == 1 else math.floor(math.log(p) / math.log1p(-rate))
            if beam >= end:
                break
            found.append(beam)
            beam, draw = beam + 1, draw + 1
    return found


def separate_echoes(echoes, separation, echoes_max):
    """Return the reported echoes [(range, width)] of one beam, near to far."""
    runs = []
    for start, width in echoes:
        if runs and start - runs[-1][0] < separation:
            runs[-1][1] = max(runs[-1][1], start + width - runs[-1][0])
        elif len(runs) < echoes_max:
            runs.append([start, width])
        else:
            break
    return runs


def cluster_echo(key, frame, purpose, clusters, beam, beams, origin, rotation, velocity):
    """Return the range of the nearest echo of one beam [m]; clusters are (centre, radius, share, tag)."""
    unit, index = int(beams.unit[beam]), int(beams.index[beam])
    azimuth, elevation = beams.azimuth[beam], beams.elevation[beam]
    ahead = [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)]
    heading = rotation[unit] @ ahead
    start = origin[unit] + beams.time_offset[beam] * np.array([*velocity, 0.0])
    nearest = math.inf
    for centre, radius, share, tag in clusters:
        to = centre - start
        middle = to @ heading
        miss = np.linalg.norm(to - middle * heading)
        if miss >= radius or middle <= 0.0:
            continue
        chance, place = uniforms(key, frame, unit + 256 * purpose, index, tag)
        along = middle + (2 * place - 1) * math.sqrt(radius**2 - miss**2)
        if chance < share and along > 0:
            nearest = min(nearest, along)
    return nearest


def mirrored_ray(at, heading, normal, f0, quality):
    """Return the mirrored ray of one that ends at `at`, and its share of the power; None from behind."""
    cosine = -(heading @ normal)
    if cosine <= 0:
        return None
    share = quality * (f0 + (1 - f0) * (1 - cosine) ** 5)
    return np.array([*(at + 0.001 * normal), *(heading + 2 * cosine * normal), share])


def moved(vector, yaw, shift=(0.0, 0.0)):
    """Rotate a vector (3,) about z, then shift it in plan."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ vector + [*shift, 0.0]

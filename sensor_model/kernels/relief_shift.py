"""Displacement of echoes by the relief of the surfaces they are on."""

import math

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.sensor_model.kernels.records import RoughPlanes
from luxloop.sensor_model.kernels.straight_points import straight_point

_LEAST_COSINE = 0.3  # of incidence for a displacement along a beam; details hide each other at grazing incidence


@kernel()
def shift_to_relief(
    target: Ints, surface: Ints, direction: Floats, planes: RoughPlanes, scale: float, ranges: Floats, points: Floats
) -> None:
    """Move N echoes to the relief of their surfaces: a height h moves an echo by -h / cos(incidence) along its beam.

    Parameters
    ----------
    target, surface, direction
        (N,), (N,), (N, 3) as in `Echoes`.
    scale
        Factor of the heights.
    ranges, points
        (N,), (N, 3) in and out: range [m], and point in the frame of its body [m].
    """
    normals, turn, relief, pivot, waves = planes
    per_wave = scale * math.sqrt(2.0 / waves.shape[1])
    for e in range(len(target)):
        a, q = target[e], surface[e]
        if a < 0 or relief[q] == 0.0:
            continue
        x, y = straight_point(points[e, 0], points[e, 1], turn[q], pivot[q])
        height = 0.0
        for w in range(waves.shape[1]):
            height += elementary.cos(
                waves[a, w, 0] * x + waves[a, w, 1] * y + waves[a, w, 2] * points[e, 2] + waves[a, w, 3]
            )
        cosine = 0.0
        for axis in range(3):
            cosine -= normals[q, axis] * direction[e, axis]
        shift = -per_wave * relief[q] * height / max(cosine, _LEAST_COSINE)
        ranges[e] += shift
        for axis in range(3):
            points[e, axis] += shift * direction[e, axis]

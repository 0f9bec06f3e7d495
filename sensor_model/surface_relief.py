"""Displacement of echoes by the relief of the surfaces they are on."""

from dataclasses import replace

import numpy as np

from sensor_model.bodies.relief import WAVES
from sensor_model.bodies.scene import Bodies
from sensor_model.raycaster import Echoes

_LEAST_COSINE = 0.3
"""Least cosine of incidence for the displacement along a beam; details hide each other at grazing incidence."""


def displace(echoes: Echoes, bodies: Bodies, scale: float) -> Echoes:
    """Move echoes to the relief of their surfaces: a height h moves an echo by -h / cos(incidence) along its beam.

    Parameters
    ----------
    echoes
        Echoes of the solids.
    scale
        Factor of the heights; 0 returns the echoes unchanged.
    """
    rough = np.flatnonzero(echoes.target >= 0)
    rough = rough[bodies.plane_relief[echoes.surface[rough]] > 0.0]
    if scale == 0.0 or len(rough) == 0:
        return echoes
    target, surface, direction = echoes.target[rough], echoes.surface[rough], echoes.direction_body[rough]
    point = echoes.point_body[rough]
    point[:, :2] = bodies.straight_points(target, surface, point[:, :2])
    waves = bodies.relief_waves[target]
    phase = np.einsum("nwi,ni->nw", waves[:, :, :3], point) + waves[:, :, 3]
    height = scale * bodies.plane_relief[surface] * np.sqrt(2.0 / WAVES) * np.cos(phase).sum(axis=1)
    cosine = -np.einsum("ni,ni->n", bodies.planes[surface, :3], direction)
    shift = -height / np.maximum(cosine, _LEAST_COSINE)
    ranges, points = echoes.range.copy(), echoes.point_body.copy()
    ranges[rough] += shift
    points[rough] += shift[:, None] * direction
    return replace(echoes, range=ranges, point_body=points)

"""Relief: details of fronts and rears that the solids leave out, such as grilles, lamps, plates and badges.

The surface deviates from the faces of the solids by a random height, constant over time in the frame of the body: a sum
of cosines sqrt(2 / n) sigma cos(k . p + phase) with random wave vectors k (spectral representation, Shinozuka and
Deodatis 1991).
"""

import math

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bytes, Floats
from luxloop.sensor_model.bodies.proportions import Draw
from luxloop.sensor_model.truth import Part

WAVES = 8
_SHORTEST, _LONGEST = 0.12, 0.60
"""[m] Wavelengths: from a lamp's or a grille bar's size to that of a plate or a grille."""


def waves(draw: Draw) -> Floats:
    """Draw (WAVES, 4) wave vectors [rad/m], in the body's y-z plane, and phases [rad]."""
    rows = []
    for _ in range(WAVES):
        number, direction = 2.0 * math.pi / draw(_SHORTEST, _LONGEST), draw(0.0, math.pi)
        rows.append(
            (0.0, number * elementary.cos(direction), number * elementary.sin(direction), draw(0.0, 2.0 * math.pi))
        )
    return np.array(rows)


def plane_relief(part: Bytes, planes: Floats, depth: float) -> Floats:
    """Return the standard deviation (Q,) of the relief of planes [m]: `depth` on painted fronts and rears.

    It falls with the square of the cosine between the normal and the body's axis, so that sides are smooth.
    """
    return np.where(part == Part.BODY, depth * planes[:, 0] ** 2, 0.0)

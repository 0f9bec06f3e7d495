"""Rotation of bodies by pitch and roll."""

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats


def tilt_rotations(attitude: Floats) -> Floats:
    """Return (N, 3, 3) rotations R of attitudes (N, 2), as in `luxloop.sim.world.Actors`: level = R body.

    The pitch is about y, then the roll about x; the axes of the level frame are those of a body without both.
    """
    (cp, cr), (sp, sr) = elementwise.cos(attitude).T, elementwise.sin(attitude).T
    zero = np.zeros_like(cp)
    rows = [[cp, sp * sr, sp * cr], [zero, cr, -sr], [-sp, cp * sr, cp * cr]]
    return np.ascontiguousarray(np.array(rows).transpose(2, 0, 1))

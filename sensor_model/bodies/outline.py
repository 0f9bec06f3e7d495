"""Outline of a body in plan: the convex hull of its solids."""

from collections.abc import Sequence

import numpy as np
import scipy

from luxloop.arrays import Floats
from luxloop.sensor_model.bodies.solids import Solid


def outline(solids: Sequence[Solid], stretch: Floats) -> Floats:
    """Return the (E, 3) edges of the outline: outward unit normals and offsets [m].

    Parameters
    ----------
    solids
        Solids of the body. Side mirrors and what is behind glass do not count.
    stretch
        (3,) factors of the solids' coordinates.
    """
    outer = [solid.corners()[:, :2] for solid in solids if not (solid.is_mirror or solid.inner)]
    edges = scipy.spatial.ConvexHull(np.concatenate(outer) * stretch[:2]).equations
    return np.column_stack([edges[:, :2], -edges[:, 2]])

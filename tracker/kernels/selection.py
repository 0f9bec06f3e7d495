"""Hot loops of best selection."""

import math

import numpy as np
from numba import njit

from tracker.records import Floats, Ints


@njit(cache=True)
def side_distances(points: Floats, offset: Ints, heading: Floats) -> Floats:
    """Distance (N, M) of points to the side of a rectangle that their line lies along, moved to the line's median.

    Line g has points offset[g] to offset[g + 1] and candidate headings (G, M). Of a rectangle's two directions it
    lies along the one that its points spread less across.
    """
    distance = np.empty((len(points), heading.shape[1]))
    for g in range(len(offset) - 1):
        x, y = points[offset[g] : offset[g + 1], 0], points[offset[g] : offset[g + 1], 1]
        for m in range(heading.shape[1]):
            cos, sin = math.cos(heading[g, m]), math.sin(heading[g, m])
            along, across = cos * x + sin * y, cos * y - sin * x
            place = across if across.std() <= along.std() else along
            distance[offset[g] : offset[g + 1], m] = np.abs(place - np.median(place))
    return distance

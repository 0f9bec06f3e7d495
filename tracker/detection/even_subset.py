"""Even subsets of the points of segments."""

import numpy as np

from tracker.arrays import Floats, Ints
from tracker.detection.kernels.bearings import bearing_keys


def even_subset(points: Floats, segment: Ints, offset: Ints, count: int) -> tuple[Ints, Ints]:
    """Return up to `count` points of each segment, evenly spaced along the outline that the ego sees.

    The order of the points of a segment has no effect: they are sorted by bearing from their mean.

    Parameters
    ----------
    points
        (N, 2 or more) grouped by segment [m].
    segment, offset
        (N,) segment of each point, ascending; (S + 1,) first point of each segment, and N.

    Returns
    -------
    tuple
        Indices of the chosen points (K,), grouped by segment, and the first one of each segment (S + 1,), and K.
    """
    by_bearing = np.lexsort((bearing_keys(points, offset), segment))
    size = np.diff(offset)
    kept = np.minimum(size, count)
    first = np.append(0, np.cumsum(kept))
    owner = np.repeat(np.arange(len(size)), kept)
    rank = np.arange(len(owner)) - first[owner]
    return by_bearing[offset[owner] + rank * size[owner] // kept[owner]], first

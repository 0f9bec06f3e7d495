"""Oracle for segmentation: all points of an actor after preprocessing are one segment.

Background removal and the merging of pieces, parts of the real stage, do not apply to actors. The real stage groups the
points on no actor: later stages decide if a wall or a cloud of spray is a vehicle, as without the oracle. Segments with
too few points are dropped.
"""

import numpy as np

from luxloop.scenarios.arrays import Bools, Ints
from luxloop.scenarios.grading.ownership import NO_ACTOR_ROW
from luxloop.tracker.detection.segmentation import keep_only
from luxloop.tracker.records import NOT_USED, Segments


def actors_first(point_row: Ints, keep: Bools, rest: Segments, points_min: int) -> Segments:
    """Make a segment of each actor, of the points to `keep` (N,), and append the segments of the `rest`.

    Parameters
    ----------
    point_row
        (N,) row of the actor each point lies on, -1 for none.
    rest
        Segments of the points on no actor.
    points_min
        Segments of actors with fewer points are dropped.
    """
    own = keep & (point_row != NO_ACTOR_ROW)
    count = int(point_row.max(initial=NO_ACTOR_ROW)) + 1
    actors = Segments(np.where(own, point_row, NOT_USED), count)
    actors = keep_only(actors, np.bincount(point_row[own], minlength=count) >= points_min)
    after = np.where(rest.label == NOT_USED, NOT_USED, rest.label + actors.count)
    return Segments(np.where(own, actors.label, after), actors.count + rest.count)

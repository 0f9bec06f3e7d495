"""The truth for segmentation: all points that are left of an actor after preprocessing are one segment.

Background memory and the union of a vehicle's pieces, parts of the real stage, have nothing to do with actors then.
Points on no actor are grouped by the real stage, among themselves: whether a wall or a cloud of spray is a vehicle is
for later stages to say, as it is without the oracle. Too small segments are dropped as always.
"""

import numpy as np

from scenarios.arrays import Bools, Ints
from scenarios.grading.ownership import NO_ACTOR_ROW
from tracker.detection.segmentation import keep_only
from tracker.records import NOT_USED, Segments


def actors_first(point_row: Ints, keep: Bools, rest: Segments, points_min: int) -> Segments:
    """Make a segment of each actor, for the points to `keep` (N,), and put the segments of the `rest` after them.

    Parameters
    ----------
    point_row
        (N,) row of the actor each point lies on, -1 for none.
    rest
        Segments of the points on no actor.
    points_min
        Smaller ones are dropped.
    """
    own = keep & (point_row != NO_ACTOR_ROW)
    count = int(point_row.max(initial=NO_ACTOR_ROW)) + 1
    actors = Segments(np.where(own, point_row, NOT_USED), count)
    actors = keep_only(actors, np.bincount(point_row[own], minlength=count) >= points_min)
    after = np.where(rest.label == NOT_USED, NOT_USED, rest.label + actors.count)
    return Segments(np.where(own, actors.label, after), actors.count + rest.count)

"""Rows of vehicles: neighbours in line with an object, in a lane, in a queue or along a kerb, are evidence for it."""

import math

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools, Floats
from luxloop.tracker.free_space import UNIT_OFFSET_M
from luxloop.tracker.geometry import rotate
from luxloop.tracker.records import OrientedBoxes

PARALLEL_SIN = math.sin(math.radians(7.0))
"""Maximum sine of the angle between two vehicles of a row: errors of two fits that show one side each."""

IN_LINE_M = 0.8
"""Maximum lateral distance of their centres [m]: vehicles keep to the middle of a lane, or park at a kerb."""

GAP_MAX_M = 15.0
"""Maximum gap between two vehicles of a row [m]."""

IN_ROW_LOG_ODDS = math.log(0.5 / 0.06)
"""Log-odds of a vehicle for an object in a row: 0.5 of the vehicles and 0.06 of the other objects are in one. Both
shares are of stationary tracks: simulated ones have 0.49 and 0.06, those of a real street 0.59 and 0.07."""


def in_row(boxes: OrientedBoxes, vehicles: Bools, ego_pose: Floats) -> Bools:
    """(T,) mask of objects that are in a row with a vehicle; an object in none may be the first one that is seen.

    Parameters
    ----------
    boxes
        T objects, odometry frame.
    vehicles
        (T,) mask of those that are known to be vehicles: a row of uncertain objects is no evidence.
    ego_pose
        (3,) x, y [m] and heading [rad] of the ego, which is a vehicle, too.
    """
    center = np.vstack([boxes.center[vehicles], ego_pose[:2]])
    heading, length = (
        np.append(boxes.heading[vehicles], ego_pose[2]),
        np.append(boxes.size[vehicles, 0], 2.0 * UNIT_OFFSET_M),
    )
    along, across = np.abs(np.moveaxis(rotate(center - boxes.center[:, None], -boxes.heading[:, None]), 2, 0))
    gap = along - 0.5 * (length + boxes.size[:, :1])
    parallel = np.abs(elementwise.sin(heading - boxes.heading[:, None])) < PARALLEL_SIN
    return np.asarray((parallel & (across < IN_LINE_M) & (gap > 0.0) & (gap < GAP_MAX_M)).any(axis=1))

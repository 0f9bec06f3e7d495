"""Occupancy of places in a scan: occupied, free, hidden or without returns, by the beams of each unit."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Floats32, Ints
from luxloop.compiled import kernel
from luxloop.tracker.free_space import BINS, COVERED, UNIT_OFFSET_M
from luxloop.tracker.kernels import placed
from luxloop.tracker.scan import Scan

NO_RETURN, HIDDEN, FREE, OCCUPIED = range(4)
"""States of a place, by what they tell: of several units, the one that tells most decides."""

PLACE_RADIUS_M = 0.3
"""Radius of a place [m]: the returns at all bearings of it tell its state."""

BEFORE_M = 0.5
"""A return that is nearer by this hides a place [m]: parts of one body differ by less."""

BEHIND_M = 1.0
"""Returns that are all farther by this show that a place is free [m]."""

BEHIND_FRACTION = 0.1
"""They are also farther by this fraction of the range: at a bearing that errs by half a degree, a wall that is met at
five degrees has a range that differs by as much."""

NEAREST_M = 1.5
"""Places nearer to a unit have no returns [m]: parts of the ego may be there."""


@dataclass(frozen=True, slots=True, eq=False)
class Occupancy:
    """What the U units saw in one scan, odometry frame."""

    time: float
    """Time of the scan [s]."""
    position: Floats
    """(U, 2) of the units [m]."""
    position_error_m: float
    """Largest error of the positions [m]: 0 if they are known, else that of the ego's centre."""
    nearest_m: Floats
    """(U, B) range of the nearest return by bearing [m], infinite without one."""

    @classmethod
    def of(cls, scan: Scan) -> "Occupancy":
        """Return what a scan shows."""
        unit, pose = np.asarray(scan.unit, np.int64), scan.ego_pose_odom
        if scan.unit_positions_ego is None:
            position, error = np.zeros((unit.max(initial=0) + 1, 2)), UNIT_OFFSET_M
        else:
            position, error = np.asarray(scan.unit_positions_ego, np.float64), 0.0
        nearest = nearest_returns(np.asarray(scan.points_ego, np.float32), unit, position, pose[2])
        return cls(scan.time, placed(position, pose), error, nearest)

    def states(self, places: Floats) -> Ints:
        """(...,) states of places (..., 2) [m]; NaN has no return."""
        states = states_of(
            np.ascontiguousarray(places).reshape(-1, 2), self.position, self.nearest_m, self.position_error_m
        )
        return np.asarray(states.reshape(places.shape[:-1]))


@kernel()
def nearest_returns(points: Floats32, unit: Ints, position: Floats, yaw: float) -> Floats:
    """(U, B) range of the nearest of points (N, 3) of each unit, by bearing in the odometry frame.

    Points and the positions (U, 2) of the units are in the ego frame, which is turned by a yaw angle [rad].
    """
    nearest = np.full((len(position), BINS), np.inf)
    for i in range(len(points)):
        x, y = points[i, 0] - position[unit[i], 0], points[i, 1] - position[unit[i], 1]
        range_m = elementary.hypot(x, y)
        if NEAREST_M < range_m < math.inf:
            k = math.floor((elementary.atan2(y, x) + yaw) / (2.0 * math.pi) * BINS) % BINS
            nearest[unit[i], k] = min(nearest[unit[i], k], range_m)
    return nearest


@kernel()
def states_of(places: Floats, position: Floats, nearest: Floats, error_m: float) -> Ints:
    """(C,) states of places (C, 2) [m]."""
    states = np.full(len(places), NO_RETURN)
    for c in range(len(places)):
        for u in range(len(position)):
            x, y = places[c, 0] - position[u, 0], places[c, 1] - position[u, 1]
            states[c] = max(states[c], state_of(x, y, nearest[u], error_m))
    return states


@kernel()
def state_of(x: float, y: float, nearest: Floats, error_m: float) -> int:
    """Return the state of a place relative to a unit [m] that has the nearest returns (B,)."""
    range_m = elementary.hypot(x, y)
    if not NEAREST_M + error_m < range_m < math.inf:
        return NO_RETURN
    half = elementary.asin(min((PLACE_RADIUS_M + error_m) / range_m, 1.0)) / (2.0 * math.pi) * BINS
    middle = elementary.atan2(y, x) / (2.0 * math.pi) * BINS
    first, last = math.floor(middle - half), math.floor(middle + half)
    returns, behind = 0, 0
    for k in range(first, last + 1):
        nearest_m = nearest[k % BINS]
        if nearest_m < range_m - BEFORE_M - error_m:
            return HIDDEN
        returns += nearest_m < math.inf
        behind += range_m + max(BEHIND_M, BEHIND_FRACTION * range_m) + error_m < nearest_m < math.inf
    if returns < COVERED * (last - first + 1):
        return NO_RETURN
    return FREE if behind == returns else OCCUPIED

"""Driver for highway-env with realistic lateral dynamics. Imports highway_env: import this module lazily.

highway-env's drivers change the steering angle instantly, change lanes in a second with 34 m/s^2 of lateral
acceleration, drive at 16 m/s in a roundabout of 20 m radius, and reverse in queues. Smoothing cannot turn such motions
into feasible ones.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from highway_env.road.regulation import RegulatedRoad
from highway_env.vehicle.behavior import IDMVehicle

from luxloop import elementary, elementwise
from luxloop.arrays import Floats
from luxloop.sim.highway.environment import SIMULATION_HZ

COMFORTABLE_ACCELERATION = 3.5
"""[m/s^2] Lateral acceleration to which a driver slows down before a bend; most stay below it in everyday traffic."""
LATERAL_ACCELERATION_MAX = 4.2
"""[m/s^2] Limit of the lateral acceleration by steering."""
LATERAL_JERK = 8.0
"""[m/s^3] Limit of the lateral jerk by steering."""
SLOW = 3.0
"""[m/s] Minimum speed assumed by the steering limits."""
BEND_DECELERATION = 2.5
"""[m/s^2] Deceleration before bends."""
YIELD_DECELERATION = 4.0
"""[m/s^2] Deceleration to give way."""
PREVIEW_S, PREVIEW_M = 1.2, 7.0
"""[s] Look-ahead time of steering, and its minimum distance [m]."""
SAMPLE_M = 2.0
"""[m] Spacing of the positions at which a driver checks for bends."""
SIGHT_M = 40.0
"""[m] Range within which vehicles on other roads matter."""
CHECK_EVERY = 5
"""Simulation steps between two checks of these vehicles."""
STANDING = 0.5
"""[m/s] A slower vehicle has no way to give: it may only be in the way."""
STOP_DECELERATION = 2.5
"""[m/s^2] Deceleration before a vehicle in the way, up to the class's limit if it appears late."""
STOP_SETTLING_S = 0.5
"""[s] Time constant of this deceleration."""
STOP_GAP = 1.5
"""[m] Distance kept from a vehicle in the way."""
SIDE_GAP = 0.3
"""[m] Distance to the side at which a vehicle is not in the way."""


class Motorist(IDMVehicle):  # type: ignore[misc]  # highway-env has no types
    """Driver that keeps its distance by IDM and chooses lanes by MOBIL, as its parent, with limited steering.

    It steers by pure pursuit: the rear axle follows the arc to a point ahead (Coulter, "Implementation of the Pure
    Pursuit Path Tracking Algorithm", CMU-RI-TR-92-01, 1992). It slows down before bends, and gives way to vehicles on
    other roads if a collision is possible and highway-env's intersection rules demand it. It stops before a vehicle of
    another road that stands in its way, or will when it has braked, also with right of way. It never reverses.
    """

    speed: float
    """[m/s] of the box centre."""

    def __init__(self, *args: Any, **keys: Any):
        super().__init__(*args, **keys)
        self._steps, self._gives_way, self._clear = 0, False, math.inf
        self.speed = min(self.speed, _bend_speed(self.lane, self._progress(self.lane_index)))

    def act(self, action: Any = None) -> None:
        """Decide on steering and acceleration."""
        if self.crashed:
            return
        super().act(action)
        self._steps += 1
        if self._steps % CHECK_EVERY == 0:
            self._gives_way = any(self._gives_way_to(other) for other in self.road.vehicles)
            self._clear = self._clear_way()
        else:
            self._clear -= max(self.speed, 0.0) / SIMULATION_HZ
        limit = min(-YIELD_DECELERATION if self._gives_way else self._before_bends(), self._before_obstruction())
        standstill = -self.speed * SIMULATION_HZ
        self.action["acceleration"] = max(min(self.action["acceleration"], limit), standstill)

    def steering_control(self, target_lane_index: Any) -> float:
        """Return the steering angle [rad] to follow a lane."""
        ahead = np.array([max(PREVIEW_S * self.speed, PREVIEW_M)])
        ((lane, along),) = self._path_ahead(target_lane_index, ahead)
        heading = np.array([elementary.cos(self.heading), elementary.sin(self.heading)])
        aim = lane.position(along, 0) - (self.position - 0.5 * self.LENGTH * heading)
        curvature = 2.0 * float(heading[0] * aim[1] - heading[1] * aim[0]) / float(aim[0] ** 2 + aim[1] ** 2)
        square = max(self.speed, SLOW) ** 2
        before = elementary.tan(self.action["steering"]) / self.LENGTH
        curvature_max, curvature_step = LATERAL_ACCELERATION_MAX / square, LATERAL_JERK / square / SIMULATION_HZ
        curvature = float(
            np.clip(np.clip(curvature, -curvature_max, curvature_max), before - curvature_step, before + curvature_step)
        )
        return elementary.atan(self.LENGTH * curvature)

    def predict_trajectory_constant_speed(self, times: Floats) -> tuple[list[Floats], list[float]]:
        """Return positions (T, 2) and headings at `times` (T,) [s] ahead, along the path to be followed."""
        places = list(self._path_ahead(self.target_lane_index, self.speed * times))
        return [lane.position(along, 0) for lane, along in places], [lane.heading_at(along) for lane, along in places]

    def _gives_way_to(self, other: Any) -> bool:
        return (
            isinstance(other, Motorist)
            and other.speed > STANDING
            and other.lane_index[:2] != self.lane_index[:2]
            and math.dist(other.position, self.position) < SIGHT_M
            and RegulatedRoad.is_conflict_possible(self, other)
            and RegulatedRoad.respect_priorities(self, other) is self
        )

    def _clear_way(self) -> float:
        """Return the distance that the front may drive [m] until a vehicle of another road is in the way."""
        reach = 0.5 * self.speed**2 / STOP_DECELERATION + STOP_GAP + self.speed * CHECK_EVERY / SIMULATION_HZ
        near = (
            other
            for other in self.road.vehicles
            if other.lane_index[:2] != self.lane_index[:2]
            and math.dist(other.position, self.position) < reach + SIGHT_M
        )
        resting = [pose for pose in map(_resting_pose, near) if pose is not None]
        if not resting:
            return math.inf
        ahead = np.arange(0.5 * self.LENGTH, 0.5 * self.LENGTH + reach + 1.0, 1.0)
        way = np.array([lane.position(along, 0) for lane, along in self._path_ahead(self.target_lane_index, ahead)])
        blocked = np.zeros(len(way), np.bool_)
        for position, heading in resting:
            offset, cos, sin = way - position, elementary.cos(heading), elementary.sin(heading)
            beyond = np.abs(elementwise.product(offset, [[cos, -sin], [sin, cos]])) - (
                0.5 * self.LENGTH,
                0.5 * self.WIDTH,
            )
            blocked |= elementwise.hypot(*np.maximum(beyond, 0.0).T) < 0.5 * self.WIDTH + SIDE_GAP
        return float(ahead[blocked.argmax()] - ahead[0] - STOP_GAP) if blocked.any() else math.inf

    def _before_obstruction(self) -> float:
        """Return the highest acceleration [m/s^2] that allows to stop before the next vehicle in the way."""
        if self._clear == math.inf:
            return math.inf
        allowed = math.sqrt(2.0 * STOP_DECELERATION * max(self._clear, 0.0))
        return max((allowed - self.speed) / STOP_SETTLING_S, -float(self.ACC_MAX))

    def _before_bends(self) -> float:
        """Return the highest acceleration [m/s^2] that allows for the bends within braking distance."""
        speed = max(self.speed, 0.0)
        ahead = np.arange(0.0, 0.5 * speed**2 / BEND_DECELERATION + SAMPLE_M, SAMPLE_M)
        allowed = np.array([_bend_speed(*place) for place in self._path_ahead(self.target_lane_index, ahead)])
        needed: Floats = (allowed**2 - speed**2) / (2.0 * np.maximum(ahead, 1.0))
        return float(max(needed.min(), -self.ACC_MAX))

    def _path_ahead(self, index: Any, ahead: Floats) -> Iterator[tuple[Any, float]]:
        """Yield lane and position along it [m] at ascending distances `ahead` [m] along a lane and its successors."""
        network, route = self.road.network, list(self.route or [])
        passed = -self._progress(index)
        for distance in ahead.tolist():
            while distance - passed > (length := network.get_lane(index).length):
                onward = network.next_lane(index, route, network.get_lane(index).position(length, 0))
                if onward == index:
                    break  # extrapolate the last lane
                index, passed = onward, passed + length
            yield network.get_lane(index), distance - passed

    def _progress(self, index: Any) -> float:
        return float(self.road.network.get_lane(index).local_coordinates(self.position)[0])


def _resting_pose(vehicle: Any) -> tuple[Floats, float] | None:
    """Return the position and heading of a vehicle when it has braked; None for one that drives on.

    Such a vehicle is out of the way later, or the rules of the intersection decide.
    """
    deceleration = -float(vehicle.action.get("acceleration", 0.0))
    if abs(vehicle.speed) > STANDING and deceleration < STOP_DECELERATION:
        return None
    way = 0.5 * vehicle.speed**2 / max(deceleration, STOP_DECELERATION)
    return vehicle.position + way * np.array(
        [elementary.cos(vehicle.heading), elementary.sin(vehicle.heading)]
    ), vehicle.heading


def _bend_speed(lane: Any, along: float) -> float:
    """Return the highest speed [m/s] at a position along a lane."""
    turn = float(lane.heading_at(along + 0.5) - lane.heading_at(along - 0.5))
    return math.sqrt(COMFORTABLE_ACCELERATION / max(abs(math.remainder(turn, 2.0 * math.pi)), 1e-6))

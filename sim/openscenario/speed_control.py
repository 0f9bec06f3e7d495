"""Speed of an entity under the actions of a storyboard."""

import math
from collections.abc import Mapping

from luxloop.sim.openscenario.distances import ahead_on_road, free_space
from luxloop.sim.openscenario.storyboard import DistanceAction, SpeedAction
from luxloop.sim.openscenario.transitions import share, speed_duration
from luxloop.sim.openscenario.traveller import Traveller

STIFFNESS = 4.0
"""[1/s^2] Spring constant of the controller of distances, which is critically damped."""
REACHED_M, REACHED_MPS = 0.05, 0.05
"""[m], [m/s] A distance counts as reached within this distance and relative speed."""


class SpeedChange:
    """Speed change of a `SpeedAction`, from now on."""

    def __init__(self, action: SpeedAction, own: Traveller, others: Mapping[str, Traveller]):
        self._action = action
        self._begin = own.speed
        self._target = self._wanted(others, own.speed)
        self._duration = speed_duration(action.dynamics, own.speed, self._target)
        self._elapsed = 0.0
        self.done = False

    def speed(self, step: float, _own: Traveller, others: Mapping[str, Traveller]) -> float:
        """Return the speed [m/s] after a step [s]; 0 returns the speed right now."""
        self._elapsed += step
        if self._action.continuous:
            self._target = self._wanted(others, self._target)
        progress = round(self._elapsed / self._duration, 9) if self._duration > 0 else 1.0
        self.done = progress >= 1 and not (self._action.entity and self._action.continuous)
        return self._begin + (self._target - self._begin) * share(self._action.dynamics, progress)

    def _wanted(self, others: Mapping[str, Traveller], otherwise: float) -> float:
        if not self._action.entity:
            return self._action.target
        other = others.get(self._action.entity)
        if other is None:
            return otherwise
        target = self._action.target
        return max(other.speed * target if self._action.factor else other.speed + target, 0.0)


class DistanceControl:
    """Control of the distance of a `LongitudinalDistanceAction`, as a critically damped spring with limits."""

    def __init__(self, action: DistanceAction):
        self._action = action
        self.done = False

    def speed(self, step: float, own: Traveller, others: Mapping[str, Traveller]) -> float:
        """Return the speed [m/s] after a step [s]. Without the other entity it stays the same."""
        action, other = self._action, others.get(self._action.entity)
        ahead = ahead_on_road(own, other) if other else None
        if other is None or ahead is None:
            return own.speed
        gap = free_space(own, other, ahead) if action.freespace else ahead
        wanted = action.time_gap * own.speed if action.distance is None else action.distance
        excess, approach = gap - wanted, own.speed - other.speed
        self.done = not action.continuous and abs(excess) < REACHED_M and abs(approach) < REACHED_MPS
        acceleration = STIFFNESS * excess - 2 * math.sqrt(STIFFNESS) * approach
        acceleration = min(max(acceleration, -action.deceleration), action.acceleration)
        return min(max(own.speed + acceleration * step, 0.0), max(action.speed, own.speed - action.deceleration * step))

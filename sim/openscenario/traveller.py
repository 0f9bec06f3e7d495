"""Motion of one entity along the lanes of a road network."""

import math
from dataclasses import dataclass

from luxloop import elementary
from luxloop.sim.opendrive.road import Road
from luxloop.sim.opendrive.road_network import RoadNetwork
from luxloop.sim.openscenario.storyboard import Dynamics, Entity, LaneChangeAction
from luxloop.sim.openscenario.trajectory import STANDING_M, Trajectory
from luxloop.sim.openscenario.transitions import lane_change_extent, share
from luxloop.sim.xml_tree import XmlElement

NARROWEST = 0.05
"""Least distance of a lane from the centre of its bend, as a share of the bend's radius."""


@dataclass(slots=True, eq=False)
class LaneChange:
    """A lane change that has begun."""

    action: LaneChangeAction
    dynamics: Dynamics
    beginning: float
    """[m] Offset from the end of the lane change, at its beginning."""
    duration: float
    """[s]"""
    length: float
    """[m]"""
    elapsed: float = 0.0
    travelled: float = 0.0

    @property
    def progress(self) -> float:
        """Share of duration or length, 1 at the end."""
        least = 1e-9
        progress = max(self.elapsed / max(self.duration, least), self.travelled / max(self.length, least))
        return round(progress, 9)  # so that the sum of all steps reaches 1

    @property
    def remaining(self) -> float:
        """Offset [m] from the end of the lane change."""
        return self.beginning * (1 - share(self.dynamics, self.progress))


class Traveller:
    """Entity on a lane, or on a trajectory.

    Parameters
    ----------
    entity
        The entity.
    network
        Its roads.
    road, lane, s, offset
        Position of the reference point: road, lane, position [m] along the reference line, and offset [m] to the left
        of the lane's centre.
    forward
        1 for driving along the reference line, -1 against it. Lane changes do not change it.
    """

    def __init__(
        self, entity: Entity, network: RoadNetwork, road: Road, lane: int, s: float, offset: float, forward: int
    ):
        self.entity, self.network = entity, network
        self.change: LaneChange | None = None
        self.trajectory: Trajectory | None = None
        """Trajectory in place of the lane, which is that of its beginning."""
        self.speed = self.travelled = self.standing = 0.0
        self.gone = False
        self.route: list[str] = []
        """Roads to take after this one; beyond them, and without any, straight ahead."""
        self._route_source: XmlElement | None = None
        self.put(road, lane, s, offset, forward)

    def put(self, road: Road, lane: int, s: float, offset: float, forward: int) -> None:
        """Put the entity on a lane, see the parameters of the class."""
        self.road, self.s, self.forward = road, s, forward
        self.offset, self.trajectory = offset, None
        self._lane = lane
        self._course = 0.0
        self.t = road.centre(s, lane) + offset

    @property
    def lane(self) -> int:
        """Lane that contains the reference point, or the followed lane if it is beside all lanes."""
        found = self.road.lane_at(self.s, self.t)
        return self._lane if found is None else found

    @property
    def pose(self) -> tuple[float, float, float]:
        """Pose of the reference point: x [m], y [m] and yaw [rad]."""
        if self.trajectory:
            return self.trajectory.pose
        x, y, heading, _ = self.road.pose(self.s, self.t)
        return x, y, heading + (0.0 if self.forward > 0 else math.pi) + self._course

    @property
    def centre(self) -> tuple[float, float, float]:
        """Pose of the box centre."""
        x, y, yaw = self.pose
        ahead, left = self.entity.centre
        cos, sin = elementary.cos(yaw), elementary.sin(yaw)
        return x + cos * ahead - sin * left, y + sin * ahead + cos * left, yaw

    def change_lane(self, action: LaneChangeAction, lane: int) -> None:
        """Begin a lane change to a lane of the road, which must exist here."""
        beginning = self.t - self.road.centre(self.s, lane) - action.offset
        duration, length = lane_change_extent(action.dynamics, beginning)
        self._lane, self.offset = lane, action.offset
        self.change = LaneChange(action, action.dynamics, beginning, duration, length)

    def end_lane_change(self) -> None:
        """Stop a lane change where it is; the entity keeps its offset from the target lane."""
        if self.change:
            self.offset += self.change.remaining
            self.change = None

    def move(self, step: float, speed: float) -> None:
        """Move for a time [s] while the speed changes linearly to a new one [m/s], if no trajectory has times."""
        distance = (self.speed + speed) / 2 * step
        if self.trajectory:
            distance = self.trajectory.advance(step, distance)
            moving = self.trajectory.speed if self.trajectory.timed else speed
            speed = moving if distance > 0 else 0.0
        self.speed, self.travelled = speed, self.travelled + distance
        self.standing = self.standing + step if speed == 0 else 0.0
        if not self.trajectory:
            self._move_along_lane(step, distance)

    def take_route(self, roads: list[str], source: XmlElement) -> None:
        """Take these roads, in order, after this one."""
        self.route, self._route_source = roads, source

    def _move_along_lane(self, step: float, distance: float) -> None:
        before, across = self.t, self._across(step, distance)
        along = math.sqrt(max(distance**2 - across**2, 0.0))
        stretch = max(1 - self.road.curvature(self.s) * self.t, NARROWEST)
        road, section = self.road, self.road.section(self.s)
        self.s += self.forward * along / stretch
        if not 0 <= self.s <= self.road.length:
            self._leave_road()
        elif road.section(self.s) is not section:
            self._enter_section(section.follower(self._lane, self.forward))
        if self.gone:
            return
        offset = self.offset + (self.change.remaining if self.change else 0.0)
        self.t = self.road.centre(self.s, self._lane) + offset
        if road is self.road and along > STANDING_M:
            self._course = elementary.atan2(self.forward * (self.t - before), along)

    def _across(self, step: float, distance: float) -> float:
        """Advance the lane change, and return its lateral step [m]."""
        if not (change := self.change):
            return 0.0
        before = change.remaining
        change.elapsed += step
        change.travelled += distance
        return change.remaining - before

    def _enter_section(self, linked: int | None) -> None:
        """Follow the lane into another section of the road; without a link, take the lane at the same place."""
        section = self.road.section(self.s)
        lane = linked if linked is not None and linked in section.lanes else self.road.lane_at(self.s, self.t)
        if lane is None:
            self.gone = True
            return
        shift = self.t - self.road.centre(self.s, lane) - self.offset - (self.change.remaining if self.change else 0.0)
        self._lane = lane
        self.offset += shift

    def _leave_road(self) -> None:
        """Go on to the next road, or leave the network."""
        beyond = self.s - self.road.length if self.forward > 0 else -self.s
        to = self.route.pop(0) if self.route else None
        following = self.network.next_lane(self.road, self._lane, self.forward, to)
        if following is None:
            if to is not None:
                self._require_lane_to(to)
            self.gone = True
            return
        if following.forward != self.forward:
            self.offset = -self.offset
            if self.change:
                self.change.beginning = -self.change.beginning
        self.road, self._lane, self.forward = following.road, following.lane, following.forward
        self.s = min(beyond, self.road.length) if self.forward > 0 else max(self.road.length - beyond, 0.0)

    def _require_lane_to(self, road: str) -> None:
        """Raise a TrafficInputError, because a road of the route does not follow on this lane."""
        assert self._route_source is not None
        lanes = ", ".join(str(lane) for lane in self.network.lanes_to(self.road, self.forward, road))
        raise self._route_source.error(
            f"leads to road {road}, which lane {self._lane} of road {self.road.id} does not reach; "
            f"change to lane {lanes} before the end of road {self.road.id}"
        )

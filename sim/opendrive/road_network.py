"""All roads of an OpenDRIVE file, and the way from one lane to the next."""

import heapq
import math
from dataclasses import dataclass
from pathlib import Path

from luxloop import elementary
from luxloop.sim.opendrive.road import Road, read_road
from luxloop.sim.xml_tree import XmlElement, read_xml

STEP_M = 2.0
"""[m] Distance of the points at which the nearest road is searched."""


@dataclass(frozen=True, slots=True)
class Connection:
    """A way through a junction, from a lane of the incoming road to one of another road."""

    incoming: str
    road: str
    at_start: bool
    """The other road is entered at its start."""
    lanes: dict[int, int]


@dataclass(frozen=True, slots=True)
class NextLane:
    """Lane that follows at the end of a road."""

    road: Road
    lane: int
    forward: int
    """1 if it is driven along its reference line, -1 if against it."""


@dataclass(frozen=True, slots=True, eq=False)
class RoadNetwork:
    """Roads by id, and connections by junction."""

    roads: dict[str, Road]
    junctions: dict[str, list[Connection]]

    def next_lane(self, road: Road, lane: int, forward: int, to: str | None = None) -> NextLane | None:
        """Return the lane that follows at the end of a road, or None at the end of the network.

        In a junction, the lane that goes most nearly straight ahead is taken.

        Parameters
        ----------
        road, lane
            Lane that ends.
        forward
            1 if it is driven along the reference line, -1 if against it.
        to
            Only lanes of this road may follow; None for any.
        """
        ways = [one for one in self._ways(road, lane, forward) if to in (None, one.road.id)]
        heading = road.pose(road.length if forward > 0 else 0.0, 0.0)[2] + (0.0 if forward > 0 else math.pi)
        return min(ways, key=lambda one: abs(_turn(one, heading)), default=None)

    def shortest_way(self, road: Road, forward: int, goal: Road) -> list[tuple[Road, int]] | None:
        """Return the roads after a road on the shortest way to another, with their directions; None without a way.

        On each road all lanes of the direction are open, because entities may change lanes.
        """
        waiting: list[tuple[float, int, list[tuple[Road, int]]]] = [(0.0, 0, [(road, forward)])]
        seen = set()
        count = 0
        while waiting:
            length, _, way = heapq.heappop(waiting)
            last, direction = way[-1]
            if last is goal:
                return way[1:]
            if (last.id, direction) in seen:
                continue
            seen.add((last.id, direction))
            for lane in self._end_lanes(last, direction):
                for one in self._ways(last, lane, direction):
                    count += 1
                    heapq.heappush(waiting, (length + one.road.length, count, [*way, (one.road, one.forward)]))
        return None

    def lanes_to(self, road: Road, forward: int, to: str) -> list[int]:
        """Return the lanes at the end of a road after which another road follows."""
        return [lane for lane in self._end_lanes(road, forward) if self.next_lane(road, lane, forward, to)]

    def _end_lanes(self, road: Road, forward: int) -> list[int]:
        """Return the lanes of a direction at the end of a road."""
        section = road.sections[-1 if forward > 0 else 0]
        return sorted(lane for lane in section.lanes if lane and road.forward(lane) == forward)

    def _ways(self, road: Road, lane: int, forward: int) -> list[NextLane]:
        """Return the lanes that follow at the end of a lane of a road."""
        end = road.after if forward > 0 else road.before
        if end is None:
            return []
        section = road.sections[-1 if forward > 0 else 0]
        if end.kind == "road":
            found = [self._enter(end.id, section.follower(lane, forward), at_start=end.at_start)]
        else:
            ways = [one for one in self.junctions.get(end.id, []) if one.incoming == road.id]
            found = [self._enter(one.road, one.lanes.get(lane), at_start=one.at_start) for one in ways]
        return [one for one in found if one is not None]

    def nearest(self, x: float, y: float) -> tuple[Road, float, float]:
        """Return the road nearest to a point [m], with the position and the offset [m] to its left."""
        road, s = min(
            ((road, s) for road in self.roads.values() for s in _positions(road.length)),
            key=lambda place: math.dist(place[0].pose(place[1], 0.0)[:2], (x, y)),
        )
        for _ in range(20):  # Newton's method on the distance along the reference line
            px, py, heading, curvature = road.pose(s, 0.0)
            along = (x - px) * elementary.cos(heading) + (y - py) * elementary.sin(heading)
            left = (y - py) * elementary.cos(heading) - (x - px) * elementary.sin(heading)
            s = min(max(s + along / max(1 - curvature * left, 0.2), 0.0), road.length)
        return road, s, left

    def _enter(self, id: str, lane: int | None, *, at_start: bool) -> NextLane | None:
        """Return the lane of a road that is entered at one of its ends, or None if it does not exist there."""
        road = self.roads.get(id)
        if road is None or lane is None or lane not in road.sections[0 if at_start else -1].lanes:
            return None
        return NextLane(road, lane, 1 if at_start else -1)


def read_network(path: Path) -> RoadNetwork:
    """Read an OpenDRIVE file. Heights, objects and signals are ignored.

    Raises
    ------
    TrafficInputError
        The file is missing or invalid.
    """
    tree = read_xml(path, "OpenDRIVE")
    roads = [read_road(element) for element in tree.all("road")]
    if not roads:
        raise tree.error("has no <road>; add one")
    return RoadNetwork(
        {road.id: road for road in roads},
        {one.text("id"): [_connection(way) for way in one.all("connection")] for one in tree.all("junction")},
    )


def _connection(element: XmlElement) -> Connection:
    road = element.text("connectingRoad", element.text("linkedRoad", ""))
    at_start = element.choice("contactPoint", {"start": "yes", "end": ""}, "start") != ""
    lanes = {one.whole("from"): one.whole("to") for one in element.all("laneLink")}
    return Connection(element.text("incomingRoad", ""), road, at_start, lanes)


def _turn(way: NextLane, heading: float) -> float:
    """Return the change of heading [rad] from the end of a road to the far end of the next."""
    far = way.road.pose(way.road.length if way.forward > 0 else 0.0, 0.0)[2] + (0.0 if way.forward > 0 else math.pi)
    return math.remainder(far - heading, 2 * math.pi)


def _positions(length: float) -> list[float]:
    count = min(math.ceil(length / STEP_M), 50_000) + 1
    return [length * n / count for n in range(count + 1)]

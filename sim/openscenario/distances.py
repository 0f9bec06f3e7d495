"""Distances between travellers, or between a traveller and a point."""

import math

from luxloop import elementary
from luxloop.sim.openscenario.storyboard import EntityCondition
from luxloop.sim.openscenario.traveller import Traveller

MOST_ROADS = 30
"""Number of roads ahead on which another entity is searched."""


def ahead_on_road(one: Traveller, other: Traveller) -> float | None:
    """Return the distance [m] of another reference point ahead along the road, negative behind; None if not found.

    On a trajectory, an entity is on no lane.
    """
    if one.trajectory or other.trajectory:
        return None
    if one.road is other.road:
        return one.forward * (other.s - one.s)
    ahead = _ahead(one, other)
    if ahead is not None:
        return ahead
    behind = _ahead(other, one)
    return None if behind is None else -behind


def _ahead(one: Traveller, other: Traveller) -> float | None:
    road, lane, forward = one.road, one.lane, one.forward
    distance = road.length - one.s if forward > 0 else one.s
    for n in range(MOST_ROADS):
        following = one.network.next_lane(road, lane, forward, one.route[n] if n < len(one.route) else None)
        if following is None:
            return None
        road, lane, forward = following.road, following.lane, following.forward
        if road is other.road:
            return distance + (other.s if forward > 0 else road.length - other.s)
        distance += road.length
        for section in (road.sections if forward > 0 else road.sections[::-1])[:-1]:
            linked = section.follower(lane, forward)
            lane = lane if linked is None else linked
    return None


def in_own_axes(one: Traveller, x: float, y: float) -> tuple[float, float]:
    """Return the distance [m] of a point ahead and to the left of a traveller's reference point."""
    own_x, own_y, yaw = one.pose
    dx, dy = x - own_x, y - own_y
    return dx * elementary.cos(yaw) + dy * elementary.sin(yaw), dy * elementary.cos(yaw) - dx * elementary.sin(yaw)


def signed_distance(test: EntityCondition, one: Traveller, other: Traveller) -> float | None:
    """Return the distance [m] from one traveller to another, as a condition measures it; None if it has none.

    Longitudinal distances are negative behind. With free space, overlapping bodies have the distance 0.
    """
    if test.axis == "euclidean":
        return math.dist(one.pose[:2], other.pose[:2])
    ahead, left = in_own_axes(one, *other.pose[:2])
    if test.axis == "lateral":
        apart = abs(left) - (one.entity.size[1] + other.entity.size[1]) / 2 if test.freespace else abs(left)
        return max(apart, 0.0)
    found = ahead_on_road(one, other) if test.along_road else ahead
    if found is None or not test.freespace:
        return found
    return free_space(one, other, found)


def free_space(one: Traveller, other: Traveller, ahead: float) -> float:
    """Return the distance [m] between two bodies whose reference points are `ahead` apart, 0 if they overlap."""
    if ahead >= 0:
        return max(ahead + other.entity.rear - one.entity.front, 0.0)
    return min(ahead + other.entity.front - one.entity.rear, 0.0)

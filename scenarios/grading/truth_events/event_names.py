"""Kinds of truth events, and names, units and meanings of the `sim` metrics. Imports quickly."""

from collections.abc import Iterator
from enum import IntEnum

from luxloop.scenarios.grading.metric_definition import Definition


class EventKind(IntEnum):
    """Kind of a truth event."""

    EGO_COLLISION = 0
    """The body of an actor overlaps the ego's, or the simulator reports a collision and shows none of it."""
    OVERLAP = 1
    """The bodies of two actors overlap."""
    TELEPORT = 2
    """A road user continues at a place that its velocity does not lead to, with the same id or a new one."""
    INSERTION = 3
    """An actor appears in view of the LIDARs."""
    REMOVAL = 4
    """An actor in view of the LIDARs vanishes."""
    ID_CHANGE = 5
    """An actor vanishes, and another of the same class and size continues in its place."""
    LIMIT_VIOLATION = 6
    """A body exceeds a limit of vehicle dynamics."""


COUNTS = {
    "ego_collisions": (
        EventKind.EGO_COLLISION,
        "overlaps of an actor's body with the ego's, and collisions by which SUMO moves one of both",
    ),
    "overlaps": (EventKind.OVERLAP, "overlaps of the bodies of two actors"),
    "teleports": (EventKind.TELEPORT, "road users that continue at a place that their velocity does not lead to"),
    "insertions_in_view": (EventKind.INSERTION, "actors that appear in view of the LIDARs, in the graded range"),
    "removals_in_view": (EventKind.REMOVAL, "actors that vanish in view of the LIDARs, in the graded range"),
    "id_changes": (EventKind.ID_CHANGE, "actors that vanish and continue in their place with another id"),
    "limit_violations": (EventKind.LIMIT_VIOLATION, "bodies that exceed a limit of acceleration, jerk or yaw rate"),
}
"""Kind and meaning of each count of events."""

LARGEST = {
    "overlap_max_m2": ("m^2", "largest overlap of two bodies, the ego's included; 0 without one"),
    "acceleration_max_mps2": ("m/s^2", "largest acceleration of any body, along and across"),
    "jerk_max_mps3": ("m/s^3", "largest change of acceleration between two frames, over the time between them"),
}
"""Unit and meaning of each extreme value."""

MASKED = "sim.masked_observations"


def definitions() -> Iterator[Definition]:
    """Yield every `sim` metric."""
    for name, (_, meaning) in COUNTS.items():
        yield Definition(f"sim.{name}", "count", meaning)
    for name, (unit, meaning) in LARGEST.items():
        yield Definition(f"sim.{name}", unit, meaning)
    yield Definition(MASKED, "count", "observations of vehicles that are not graded because of such events")

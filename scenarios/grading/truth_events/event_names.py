"""Kinds of truth events, and the metrics that count them."""

from enum import IntEnum


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
    "ego_collisions": EventKind.EGO_COLLISION,
    "overlaps": EventKind.OVERLAP,
    "teleports": EventKind.TELEPORT,
    "insertions_in_view": EventKind.INSERTION,
    "removals_in_view": EventKind.REMOVAL,
    "id_changes": EventKind.ID_CHANGE,
    "limit_violations": EventKind.LIMIT_VIOLATION,
}
"""Kind of the events that each metric counts."""

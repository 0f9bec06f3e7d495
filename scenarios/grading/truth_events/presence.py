"""Actors that appear, vanish, or continue with another id, and the places of vanished ones."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats
from luxloop.scenarios.grading.truth_events.bodies import EGO_ROW, Bodies, body_name
from luxloop.scenarios.grading.truth_events.event_limits import JUMP_M, MASK_S, REAPPEARANCE_S, SAME_SIZE_M
from luxloop.scenarios.grading.truth_events.event_names import EventKind
from luxloop.scenarios.grading.truth_events.truth_event import TruthEvent, new_event
from luxloop.sim.world import WorldFrame

TIE_S = 1e-9
"""[s] Margin of comparisons of frame times."""


@dataclass(slots=True)
class _Departed:
    """An actor that vanished."""

    id: int
    name: str
    kind: int
    pose: Floats
    velocity: Floats
    size: Floats
    time: float
    """Time of its last frame [s]."""
    in_view: bool
    """True if the LIDARs saw it in its last frame."""
    removal: TruthEvent | None
    """Its removal from view; None if it was not in view, or continues."""
    continues: bool = False
    """True if another actor, or itself at another place, continues it."""

    def box(self, time: float) -> Floats:
        """Return its box (5,) at a time, at constant velocity."""
        return np.concatenate([self.pose[:2] + (time - self.time) * self.velocity, self.pose[2:], self.size])


class Presence:
    """Finds insertions, removals, changes of id, and teleports that begin a new id."""

    def __init__(self) -> None:
        self._before: tuple[WorldFrame, Bodies, Bools] | None = None
        self._gone: list[_Departed] = []
        self._masked_until: dict[int, float] = {}

    def add(self, frame: WorldFrame, bodies: Bodies, in_view: Bools) -> list[TruthEvent]:
        """Return the events that begin in a frame.

        Parameters
        ----------
        in_view
            (M,) bodies that the LIDARs see, in the graded range.
        """
        found: list[TruthEvent] = []
        if self._before is not None:
            self._gone = [gone for gone in self._gone if frame.time - gone.time <= max(REAPPEARANCE_S, MASK_S) + TIE_S]
            if not np.array_equal(self._before[1].id, bodies.id):
                found += self._removals(bodies)
                found += self._arrivals(frame, bodies, in_view)
        self._before = frame, bodies, in_view
        return [event for event in found if not event.withdrawn]

    def jumped(self, frame: WorldFrame, bodies: Bodies, row: int, jump_m: float) -> TruthEvent:
        """Return the teleport of a body that keeps its id. Call it before `add` of the same frame."""
        assert self._before is not None
        _, before, in_view = self._before
        (old,) = np.flatnonzero(before.id == bodies.id[row])
        self._gone.append(_gone(before, int(old), body_name(frame, row), bool(in_view[old]), None))
        self._gone[-1].continues = True
        self._masked_until[int(bodies.id[row])] = frame.time + MASK_S
        return _event(EventKind.TELEPORT, frame, bodies, row, None, ("distance_m", jump_m))

    def masked(self, bodies: Bodies) -> Bools:
        """(M,) mask of bodies that are not graded after they appeared or moved in view."""
        self._masked_until = {id: until for id, until in self._masked_until.items() if until > bodies.time}
        if not self._masked_until:
            return np.zeros(len(bodies.id), np.bool_)
        return np.isin(bodies.id, list(self._masked_until))

    def ghosts(self, time: float) -> Floats:
        """(G, 5) boxes in the world frame, at constant velocity, of actors that vanished in view shortly before."""
        boxes = [gone.box(time) for gone in self._gone if gone.in_view and time - gone.time <= MASK_S + TIE_S]
        return np.array(boxes).reshape(-1, 5)

    def _removals(self, bodies: Bodies) -> list[TruthEvent]:
        """Return the events of bodies that are gone, in their last frames, and remember them."""
        assert self._before is not None
        frame, before, in_view = self._before
        events = []
        for row in np.flatnonzero(~np.isin(before.id, bodies.id, assume_unique=True)).tolist():
            removal = None
            if in_view[row]:
                speed = ("speed_mps", float(np.hypot(*before.velocity_world[row])))
                removal = _event(EventKind.REMOVAL, frame, before, row, None, speed)
                events.append(removal)
            self._gone.append(_gone(before, row, body_name(frame, row), bool(in_view[row]), removal))
        return events

    def _arrivals(self, frame: WorldFrame, bodies: Bodies, in_view: Bools) -> list[TruthEvent]:
        """Return the events of all new bodies."""
        assert self._before is not None
        new = np.flatnonzero(~np.isin(bodies.id, self._before[1].id, assume_unique=True)).tolist()
        found = (self._arrival(frame, bodies, row, bool(in_view[row])) for row in new)
        return [event for event in found if event is not None]

    def _arrival(self, frame: WorldFrame, bodies: Bodies, row: int, seen: bool) -> TruthEvent | None:
        """Return the event of a new body, if it is in view or continues one that was."""
        gone = self._predecessor(frame, bodies, row)
        if not seen and (gone is None or not gone.in_view):
            return None
        self._masked_until[int(bodies.id[row])] = frame.time + MASK_S
        if gone is None:
            speed = ("speed_mps", float(np.hypot(*bodies.velocity_world[row])))
            return _event(EventKind.INSERTION, frame, bodies, row, None, speed)
        gone.continues = True
        if gone.removal is not None:
            gone.removal.withdrawn = True
        distance = _distance(gone, frame.time, bodies.pose_world[row])
        kind = EventKind.TELEPORT if distance > JUMP_M else EventKind.ID_CHANGE
        return _event(kind, frame, bodies, row, (gone.id, gone.name), ("distance_m", distance))

    def _predecessor(self, frame: WorldFrame, bodies: Bodies, row: int) -> _Departed | None:
        """Return the vanished actor that a new body continues: of the same name, or the nearest in the same place."""
        name, place = body_name(frame, row), bodies.pose_world[row]
        like = [
            gone
            for gone in self._gone
            if not gone.continues
            and frame.time - gone.time <= REAPPEARANCE_S + TIE_S
            and gone.id != bodies.id[row]
            and gone.kind == bodies.kind[row]
            and np.abs(gone.size - bodies.size[row]).max() <= SAME_SIZE_M
        ]
        named = [gone for gone in like if _simulator_name(gone.name) == _simulator_name(name)]
        near = [gone for gone in like if _distance(gone, frame.time, place) <= JUMP_M]
        return min(named or near, key=lambda gone: _distance(gone, frame.time, place), default=None)


def _gone(bodies: Bodies, row: int, name: str, in_view: bool, removal: TruthEvent | None) -> _Departed:
    motion = bodies.pose_world[row], bodies.velocity_world[row], bodies.size[row]
    return _Departed(int(bodies.id[row]), name, int(bodies.kind[row]), *motion, bodies.time, in_view, removal)


def _distance(gone: _Departed, time: float, pose: Floats) -> float:
    """Return the distance of a pose from the place of a vanished actor, at constant velocity [m]."""
    return float(np.hypot(*(gone.box(time)[:2] - pose[:2])))


def _simulator_name(name: str) -> str:
    """Return the simulator's name of an actor; a further member of the same road user has a number behind it."""
    return name.partition("#")[0]


def _event(
    kind: EventKind,
    frame: WorldFrame,
    bodies: Bodies,
    row: int,
    other: tuple[int, str] | None,
    measure: tuple[str, float],
) -> TruthEvent:
    range_m = float(np.hypot(*(bodies.pose_world[row, :2] - bodies.pose_world[EGO_ROW, :2])))
    speed = float(np.hypot(*bodies.velocity_world[row]))
    actor = int(bodies.id[row]), body_name(frame, row)
    return new_event(kind, frame, actor, other, measure, (range_m, speed))

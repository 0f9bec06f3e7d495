"""Log of the truth events of a run, and the bodies that are not graded because of them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from luxloop.arrays import Bools, Floats
from luxloop.scenarios.grading.truth_events.bodies import (
    EGO,
    EGO_NAME,
    EGO_ROW,
    Bodies,
    Motion,
    MotionHistory,
    Overlaps,
    body_name,
    is_jump,
    overlaps,
)
from luxloop.scenarios.grading.truth_events.truth_event import (
    EPISODE_S,
    FRINGE_M,
    JUMP_M,
    LIMITS,
    MASK_S,
    REAPPEARANCE_S,
    SAME_SIZE_M,
    EventKind,
    TruthEvent,
    event_table,
    exceedance,
    new_event,
)
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Collision, WorldFrame

Key = tuple[EventKind, int, int]
"""Kind and ids of an episode."""


class Episodes:
    """Joins the collisions, overlaps and violations of single frames to events."""

    def __init__(self) -> None:
        self._open: dict[Key, tuple[TruthEvent, float]] = {}
        """Event and time of its last frame."""

    def collisions(
        self, frame: WorldFrame, bodies: Bodies, before: Bodies, reported: tuple[Collision, ...]
    ) -> list[TruthEvent]:
        """Return the collisions of the ego that the simulator reports and that begin in a frame.

        Parameters
        ----------
        before
            Bodies of the last frame: the simulator may have taken the other one off the road since.
        """
        events = []
        for one in reported:
            key, measure = (EventKind.EGO_COLLISION, one.id, EGO), ("speed_mps", one.speed_mps)
            if not self._continues(key, frame, measure, 0.0):
                seen = [at for at in (bodies, before) if one.id != EGO and one.id in at.id]
                motion = _motion(seen[0], one.id) if seen else (np.nan, np.nan)
                event = new_event(key[0], frame, (one.id, one.name), (EGO, EGO_NAME), measure, motion)
                events.append(self._opened(key, frame, event, 0.0))
        return events

    def overlaps(self, frame: WorldFrame, bodies: Bodies, found: Overlaps) -> list[TruthEvent]:
        """Return the overlaps that begin in a frame; those that last are updated."""
        events = []
        for first, second, area in zip(*(column.tolist() for column in found), strict=True):
            with_ego = first == EGO_ROW
            row, other = (second, first) if with_ego else (first, second)
            kind = EventKind.EGO_COLLISION if with_ego else EventKind.OVERLAP
            events += self._extend(kind, frame, bodies, row, other, ("overlap_m2", area), area)
        return events

    def violations(self, frame: WorldFrame, bodies: Bodies, motion: Motion) -> list[TruthEvent]:
        """Return the violations of limits that begin in a frame; those that last are updated."""
        excess = exceedance(motion.quantities)
        worst = excess.argmax(axis=1)
        events = []
        for row in np.flatnonzero(excess.max(axis=1) > 1.0).tolist():
            quantity = tuple(LIMITS)[worst[row]]
            value = float(motion.quantities[row, worst[row]])
            events += self._extend(
                EventKind.LIMIT_VIOLATION, frame, bodies, row, None, (quantity, value), float(excess[row].max())
            )
        return events

    def _extend(
        self,
        kind: EventKind,
        frame: WorldFrame,
        bodies: Bodies,
        row: int,
        other: int | None,
        measure: tuple[str, float],
        badness: float,
    ) -> list[TruthEvent]:
        """Update the event of an episode and return nothing, or return a new one."""
        second = None if other is None else (int(bodies.id[other]), body_name(frame, other))
        key = kind, int(bodies.id[row]), bodies.id[row] if second is None else second[0]
        if self._continues(key, frame, measure, badness):
            return []
        first = int(bodies.id[row]), body_name(frame, row)
        event = new_event(kind, frame, first, second, measure, _motion(bodies, first[0]))
        return [self._opened(key, frame, event, badness)]

    def _continues(self, key: Key, frame: WorldFrame, measure: tuple[str, float], badness: float) -> bool:
        """Return True if the event of a key goes on, and update it."""
        event, last = self._open.get(key, (None, -np.inf))
        if event is None or frame.time - last > EPISODE_S:
            return False
        self._open[key] = event, frame.time
        event.end_frame = frame.index
        if badness > event.badness:
            event.quantity, event.value = measure
            event.badness = badness
        return True

    def _opened(self, key: Key, frame: WorldFrame, event: TruthEvent, badness: float) -> TruthEvent:
        """Return a new event, after it is noted as going on."""
        event.badness = badness
        self._open[key] = event, frame.time
        return event


def _motion(bodies: Bodies, id: int) -> tuple[float, float]:
    """Return distance from the ego [m] and speed [m/s] of the body with an id."""
    row = int(np.flatnonzero(bodies.id == id)[0])
    away = bodies.pose_world[row, :2] - bodies.pose_world[EGO_ROW, :2]
    return float(np.hypot(*away)), float(np.hypot(*bodies.velocity_world[row]))


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
        return _event_of_body(EventKind.TELEPORT, frame, bodies, row, None, ("distance_m", jump_m))

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
                removal = _event_of_body(EventKind.REMOVAL, frame, before, row, None, speed)
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
            return _event_of_body(EventKind.INSERTION, frame, bodies, row, None, speed)
        gone.continues = True
        if gone.removal is not None:
            gone.removal.withdrawn = True
        distance = _distance(gone, frame.time, bodies.pose_world[row])
        kind = EventKind.TELEPORT if distance > JUMP_M else EventKind.ID_CHANGE
        return _event_of_body(kind, frame, bodies, row, (gone.id, gone.name), ("distance_m", distance))

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


def _event_of_body(
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


@dataclass(frozen=True, slots=True, eq=False)
class FrameEvents:
    """Events of one frame with A actors."""

    began: list[TruthEvent]
    """Events that begin in this frame."""
    masked: Bools
    """(A,) actors that overlap another body, or that appeared or moved in view shortly before: they are not graded."""
    ghosts_world: Floats
    """(G, 5) boxes of actors that vanished in view shortly before: tracks there are not false."""
    extremes: dict[str, float]
    """Largest acceleration, jerk and overlap, by the column of the table `extremes`."""


class EventLog:
    """Finds the truth events of a run.

    Parameters
    ----------
    hidden_fraction_max
        An actor is in view if its visible fraction is larger, see `GradingConfig`.
    range_max_m
        Insertions and removals count up to this distance from the ego [m].
    delivered_m
        Distance up to which the traffic source delivers actors [m].
    """

    def __init__(self, hidden_fraction_max: float, range_max_m: float, delivered_m: float) -> None:
        self._hidden = hidden_fraction_max
        self._range = min(range_max_m, delivered_m - FRINGE_M)
        self._motion = MotionHistory()
        self._episodes = Episodes()
        self._presence = Presence()
        self._events: list[TruthEvent] = []
        self._last: tuple[WorldFrame, Bodies] | None = None

    def add(self, frame: WorldFrame, truth: ScanTruth) -> FrameEvents:
        """Find the events of one frame."""
        bodies = Bodies.of(frame)
        motion = self._motion.add(bodies)
        pairs = overlaps(bodies)
        jumps = np.flatnonzero(is_jump(motion)).tolist()
        began = [self._presence.jumped(frame, bodies, row, float(motion.jump_m[row])) for row in jumps]
        began += self._presence.add(frame, bodies, self._in_view(bodies, truth))
        before = self._last[1] if self._last else bodies
        began += self._episodes.collisions(frame, bodies, before, frame.collisions)
        began += self._episodes.overlaps(frame, bodies, pairs)
        began += self._episodes.violations(frame, bodies, motion)
        self._events += began
        self._last = frame, bodies
        masked = self._presence.masked(bodies)
        masked[pairs.first] = masked[pairs.second] = True
        acceleration, jerk, _ = motion.quantities.max(axis=0).tolist()
        return FrameEvents(
            began=began,
            masked=masked[EGO_ROW + 1 :],
            ghosts_world=self._presence.ghosts(frame.time),
            extremes={
                "acceleration_max_mps2": acceleration,
                "jerk_max_mps3": jerk,
                "overlap_max_m2": float(pairs.area.max()) if len(pairs.area) else 0.0,
            },
        )

    def end(self, collisions: tuple[Collision, ...]) -> None:
        """Add the collisions of the ego by which the run ended, to the last frame."""
        if self._last:
            frame, bodies = self._last
            self._events += self._episodes.collisions(frame, bodies, bodies, collisions)

    def table(self) -> pd.DataFrame:
        """Return the table `events`."""
        return event_table(self._events)

    def _in_view(self, bodies: Bodies, truth: ScanTruth) -> Bools:
        """(M,) mask of the actors that the LIDARs see, in range."""
        offset = bodies.pose_world[:, :2] - bodies.pose_world[EGO_ROW, :2]
        away = np.hypot(offset[:, 0], offset[:, 1])
        seen = np.append(False, (truth.hits > 0) & (truth.visible_fraction > self._hidden))
        return seen & (away <= self._range)

"""Events that last: overlaps of bodies, and violations of limits."""

import numpy as np

from luxloop.scenarios.grading.truth_events.bodies import EGO, EGO_NAME, EGO_ROW, Bodies, body_name
from luxloop.scenarios.grading.truth_events.body_motion import Motion
from luxloop.scenarios.grading.truth_events.body_overlaps import Overlaps
from luxloop.scenarios.grading.truth_events.event_limits import EPISODE_S, LIMITS, exceedance
from luxloop.scenarios.grading.truth_events.event_names import EventKind
from luxloop.scenarios.grading.truth_events.truth_event import TruthEvent, new_event
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

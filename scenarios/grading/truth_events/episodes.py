"""Events that last: overlaps of bodies, and violations of limits."""

import numpy as np

from scenarios.grading.truth_events.bodies import EGO_ROW, Bodies, body_name
from scenarios.grading.truth_events.body_motion import Motion
from scenarios.grading.truth_events.body_overlaps import Overlaps
from scenarios.grading.truth_events.event_limits import EPISODE_S, LIMITS, exceedance
from scenarios.grading.truth_events.event_names import EventKind
from scenarios.grading.truth_events.truth_event import TruthEvent, new_event
from sim.world import WorldFrame

Key = tuple[EventKind, int, int]
"""Kind and ids of an episode."""


class Episodes:
    """Joins the overlaps and violations of single frames to events."""

    def __init__(self) -> None:
        self._open: dict[Key, tuple[TruthEvent, float]] = {}
        """Event and time of its last frame."""

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
        event, last = self._open.get(key, (None, -np.inf))
        if event is not None and frame.time - last <= EPISODE_S:
            self._open[key] = event, frame.time
            event.end_frame = frame.index
            if badness > event.badness:
                event.quantity, event.value = measure
                event.badness = badness
            return []
        away = bodies.pose_world[row, :2] - bodies.pose_world[EGO_ROW, :2]
        motion = float(np.hypot(*away)), float(np.hypot(*bodies.velocity_world[row]))
        event = new_event(kind, frame, (int(bodies.id[row]), body_name(frame, row)), second, measure, motion)
        event.badness = badness
        self._open[key] = event, frame.time
        return [event]

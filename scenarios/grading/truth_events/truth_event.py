"""Record of a truth event, its table, and its description."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.truth_events.event_names import EventKind
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import WorldFrame

COLUMNS = (
    *("frame", "time_s", "end_frame", "kind", "actor_id", "name", "other_id", "other"),
    *("quantity", "value", "range_m", "speed_mps"),
)
KIND_NAMES = tuple(kind.name.lower() for kind in EventKind)

UNITS = {
    "overlap_m2": "m²",
    "distance_m": "m",
    "speed_mps": "m/s",
    "acceleration_mps2": "m/s²",
    "jerk_mps3": "m/s³",
    "yaw_rate_radps": "rad/s",
}
"""Unit of each quantity that measures an event, for texts."""

PHRASES = {
    EventKind.EGO_COLLISION: "the ego collided with {name}",
    EventKind.OVERLAP: "{name} and {other} overlap",
    EventKind.TELEPORT: "{name} was moved to another place",
    EventKind.INSERTION: "{name} appeared in view",
    EventKind.REMOVAL: "{name} vanished in view",
    EventKind.ID_CHANGE: "{other} continues as {name}",
    EventKind.LIMIT_VIOLATION: "{name} exceeded a limit of vehicle dynamics",
}
"""Description of each kind."""


@dataclass(slots=True)
class TruthEvent:
    """An event; overlaps and violations last, and `value` is the largest so far."""

    kind: EventKind
    frame: int
    """Index of its first frame."""
    time: float
    """Time of its first frame [s]."""
    end_frame: int
    """Index of its last frame."""
    actor_id: int
    """Id of the actor, -1 for the ego."""
    name: str
    other_id: int
    """Id of the second actor: the ego, the other body, or the id before a change; -1 for the ego and for none."""
    other: str
    """Its name, empty for none."""
    quantity: str
    """Quantity of `value`, one of `UNITS`."""
    value: float
    range_m: float
    """Distance from the ego's centre in the first frame [m]; NaN for an actor that was in no frame."""
    speed_mps: float
    """Speed of the actor in the first frame [m/s]; NaN as above."""
    badness: float = 0.0
    """Size of `value` among those of the event, whose quantities may differ."""
    withdrawn: bool = False
    """True for a removal whose actor continued with another id; it does not count as an event."""

    @property
    def text(self) -> str:
        """The event in one line."""
        phrase = PHRASES[self.kind].format(name=self.name, other=self.other)
        place = "" if np.isnan(self.range_m) else f", {self.range_m:.0f} m from the ego"
        return f"{phrase} ({self.value:.3g} {UNITS[self.quantity]}{place})"


def event_table(events: list[TruthEvent]) -> pd.DataFrame:
    """Return the table `events`: a row per event, by time."""
    ordered = sorted(
        (e for e in events if not e.withdrawn),
        key=lambda event: (event.frame, event.kind, event.actor_id, event.other_id),
    )
    columns = {
        "frame": np.array([event.frame for event in ordered], np.int64),
        "time_s": np.array([event.time for event in ordered], np.float64),
        "end_frame": np.array([event.end_frame for event in ordered], np.int64),
        "kind": pd.Categorical.from_codes(np.array([e.kind for e in ordered], np.int8), list(KIND_NAMES)),
        "actor_id": np.array([event.actor_id for event in ordered], np.int64),
        "name": np.array([event.name for event in ordered], np.dtype("O")),
        "other_id": np.array([event.other_id for event in ordered], np.int64),
        "other": np.array([event.other for event in ordered], np.dtype("O")),
        "quantity": np.array([event.quantity for event in ordered], np.dtype("O")),
        "value": np.array([event.value for event in ordered], np.float64),
        "range_m": np.array([event.range_m for event in ordered], np.float64),
        "speed_mps": np.array([event.speed_mps for event in ordered], np.float64),
    }
    return pd.DataFrame(columns, columns=list(COLUMNS))


def new_event(
    kind: EventKind,
    frame: WorldFrame,
    actor: tuple[int, str],
    other: tuple[int, str] | None,
    measure: tuple[str, float],
    motion: tuple[float, float],
) -> TruthEvent:
    """Return an event of one frame.

    Parameters
    ----------
    actor, other
        Id and name of the actor and of the second one, None without one.
    measure
        Quantity and value.
    motion
        Distance from the ego [m] and speed [m/s].
    """
    other_id, other_name = (NO_ACTOR, "") if other is None else other
    return TruthEvent(kind, frame.index, frame.time, frame.index, *actor, other_id, other_name, *measure, *motion)

"""Record of a truth event, its table, and its description."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.metrics.definitions import EVENT_EXTREMES
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import Kind, WorldFrame


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


OVERLAP_M2 = 0.05
"""[m^2] Least overlap of two boxes that is an overlap of bodies. Corners of bodies are rounded: at a radius of 0.5 m a
box is (1 - pi / 4) r^2 = 0.054 m^2 larger than the body at each corner."""

JUMP_M = 1.0
"""[m] Least distance between a body and the place its velocity leads to that is a teleport. Within a frame of 0.08 s,
10 m/s^2 account for 0.03 m."""

ACCELERATION_MPS2 = 10.0
"""[m/s^2] Longitudinal and lateral together: the grip of good tyres on a dry road (Kamm's circle)."""

JERK_MPS3 = 60.0
"""[m/s^3] Twice the truth layer's limit along (`sim.physical.limits.JERK`). An emergency brake of 9 m/s^2 builds up in
0.15 s or more."""

YAW_RATE_RADPS = 1.5
"""[rad/s] Of bodies on wheels: a car on its smallest turning circle of 5 m radius at 7.5 m/s, with 11 m/s^2."""

ON_WHEELS = np.array([kind not in (Kind.PEDESTRIAN, Kind.OBSTACLE) for kind in Kind])
"""True for kinds with a limit of the yaw rate, by `Kind`; people turn on the spot."""

EPISODE_S = 1.0
"""[s] Two overlaps or violations of the same bodies are one event if the time between them is at most this long."""

REAPPEARANCE_S = 1.0
"""[s] Longest time between the end of an actor and its continuation with another id."""

SAME_SIZE_M = 0.01
"""[m] Largest difference between the sizes of one body."""

MASK_S = 1.0
"""[s] Time for which an actor that was inserted or moved in view is not graded, and for which tracks at the place of a
removed one are not false. A vehicle on a real road comes into view by degrees: at 5 m/s, 5 m of length take 1 s, and a
tracker confirms it meanwhile. `luxloop.scenarios.grading.snapshots` allows the same time for confirmation."""

FRINGE_M = 10.0
"""[m] Actors enter and leave at the border of the delivered range. They do not within this distance of it."""

LIMITS = {
    "acceleration_mps2": ACCELERATION_MPS2,
    "jerk_mps3": JERK_MPS3,
    "yaw_rate_radps": YAW_RATE_RADPS,
}
"""Limit of each checked quantity."""


def exceedance(values: Floats) -> Floats:
    """Return values (M, 3) of the quantities in `LIMITS`, in units of their limits."""
    excess: Floats = values / np.array(list(LIMITS.values()))
    return excess


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


NO_EVENTS = "the run has no table of truth events: its traffic was not simulated, or by an earlier version"


def grade_events(sheet: MetricSheet, events: pd.DataFrame | None, extremes: pd.DataFrame | None) -> None:
    """Enter every `sim` metric; without the tables they have no value."""
    known = events is not None and extremes is not None
    frames = len(extremes) if extremes is not None and known else 0
    for name, kind in COUNTS.items():
        count = int((events["kind"] == kind.name.lower()).sum()) if events is not None else None
        sheet.write(f"sim.{name}", count, frames, NO_EVENTS)
    for name in EVENT_EXTREMES:
        largest = float(extremes[name].max()) if extremes is not None and frames else None
        sheet.write(f"sim.{name}", largest, frames, NO_EVENTS)
    masked = int(extremes["masked"].sum()) if extremes is not None else None
    sheet.write("sim.masked_observations", masked, frames, NO_EVENTS)

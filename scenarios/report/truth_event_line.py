"""Sentences on the truth events of a run."""

from collections.abc import Iterator

import pandas as pd

from luxloop.scenarios.document.document import Paragraph
from luxloop.scenarios.grading.truth_events.event_names import COUNTS, EventKind
from luxloop.scenarios.result import Result
from luxloop.sim.highway.highway_config import MOTORIST

WORDS = {
    EventKind.EGO_COLLISION: ("collision of the ego", "collisions of the ego"),
    EventKind.OVERLAP: ("overlap", "overlaps"),
    EventKind.TELEPORT: ("teleport", "teleports"),
    EventKind.INSERTION: ("insertion in view", "insertions in view"),
    EventKind.REMOVAL: ("removal in view", "removals in view"),
    EventKind.ID_CHANGE: ("change of id", "changes of id"),
    EventKind.LIMIT_VIOLATION: ("violation of limits", "violations of limits"),
}
"""Singular and plural of each kind."""

DRIVERS, OWN_DRIVERS = "other_vehicles_type", "highway_env"
"""Key of highway-env's configuration that chooses the drivers, and the package of its own."""

VALUES = {
    "overlap_m2": "{:.2g} m²",
    "distance_m": "{:.2g} m",
    "speed_mps": "at {:.2g} m/s",
    "acceleration_mps2": "{:.3g} m/s²",
    "jerk_mps3": "{:.3g} m/s³",
    "yaw_rate_radps": "{:.2g} rad/s",
}
"""Format of each quantity."""


def truth_events(result: Result) -> list[Paragraph]:
    """Return the warnings about the traffic, and a line with the events of each kind; nothing without any."""
    warnings = [Paragraph(f"Warning: {warning}", "warn") for warning in result.warnings]
    events = result.tables.get("events")
    if events is None or events.empty:
        return warnings
    line = f"Traffic events: {'; '.join(_kinds(events))}"
    masked = result.metrics["sim.masked_observations"].value
    if masked:
        line += f"; {masked:.0f} observations are not graded because of them"
    return [*warnings, Paragraph(line + _remedy(result, events), "warn")]


def _remedy(result: Result, events: pd.DataFrame) -> str:
    """Return the remedy for limits that highway-env's own drivers exceed; nothing for other drivers."""
    traffic = result.config.get("traffic", {})
    drivers = traffic.get("config") if traffic.get("kind") == "highway-env" else None
    violated = (events["kind"] == EventKind.LIMIT_VIOLATION.name.lower()).any()
    if drivers is None or not violated or str(drivers.get(DRIVERS, OWN_DRIVERS)).partition(".")[0] != OWN_DRIVERS:
        return ""
    return (
        f'; highway-env\'s own drivers turn and brake harder than cars can: set traffic.config.{DRIVERS} = "{MOTORIST}"'
    )


def _kinds(events: pd.DataFrame) -> Iterator[str]:
    """Yield the number of events of each kind, and the largest of them."""
    for kind in COUNTS.values():
        found = events[events["kind"] == kind.name.lower()]
        if found.empty:
            continue
        largest = found.loc[found["value"].idxmax()]
        actors = " and ".join(name for name in (largest["name"], largest["other"]) if name)
        if kind == EventKind.EGO_COLLISION:
            actors = largest["name"]
        example = f"{actors}, {VALUES[largest['quantity']].format(largest['value'])} at {largest['time_s']:.1f} s"
        yield f"{len(found)} {WORDS[kind][len(found) > 1]} ({'' if len(found) == 1 else 'largest '}{example})"

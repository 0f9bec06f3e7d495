"""Metrics of truth events, from the tables `events` and `extremes` of a run."""

import pandas as pd

from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.truth_events.event_names import COUNTS
from luxloop.scenarios.metrics.definitions import EVENT_EXTREMES

NO_EVENTS = "the run has no table of truth events: its traffic was not simulated, or by an earlier version"


def grade(sheet: MetricSheet, events: pd.DataFrame | None, extremes: pd.DataFrame | None) -> None:
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

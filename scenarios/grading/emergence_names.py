"""Names, units and meanings of the `emergence` metrics: when an actor is seen, tracked, confirmed and located.

Stages are in the order in which they are usually reached. `target` is the actor named by `grading.target`; the other
groups hold all actors of some classes.
"""

from collections.abc import Iterator
from itertools import product

from luxloop.scenarios.grading.metric_definition import Definition
from luxloop.scenarios.grading.track_metric_names import CLASSES

STAGES = {
    "first_beam": "first frame with a beam returned from it, a scan point",
    "enough_points": "first frame with points_min scan points on it",
    "tentative": "first frame with a track on it, tentative or confirmed",
    "confirmed": "first frame with a confirmed track on it",
    "located": "first frame with a confirmed track within located_position_m and located_heading_deg",
}
"""Meaning of each stage of emergence."""

TARGET = "target"

GROUPS = {"vehicle": CLASSES, "bicycle": ("bicycle",), "person": ("pedestrian",)}
"""Classes of the actors of each group."""

MEASURES = {
    "s": ("s", "time since the start of the run"),
    "delay_s": ("s", "time since the first beam"),
    "range_m": ("m", "distance of the centres of ego and target"),
    "ttc_s": ("s", "time to collision of the boxes at constant velocities"),
    "meeting_m": ("m", "distance of the ego's front from the meeting point, along its path"),
    "meeting_s": ("s", "time until the ego's front is at the meeting point"),
}
"""Unit and meaning of each measure of the target."""

SURVIVAL = {"s": False, "delay_s": False, "meeting_m": True, "meeting_s": True}
"""Measures that only grow (False) or only fall (True) in a run: those that a survival curve may be drawn over."""

END = "end"
"""Stage-like name of the last frame with the target: there, a stage that was not reached is censored."""


def definitions() -> Iterator[Definition]:
    """Yield every `emergence` metric."""
    for (stage, when), (name, (unit, meaning)) in product(STAGES.items(), MEASURES.items()):
        yield Definition(f"emergence.{TARGET}.{stage}_{name}", unit, f"{meaning}; target, {when}")
    for stage, when in STAGES.items():
        yield Definition(f"emergence.{TARGET}.{stage}_reached", "1", f"1 if the target reaches: {when}")
    for name in SURVIVAL:
        unit, meaning = MEASURES[name]
        yield Definition(f"emergence.{TARGET}.{END}_{name}", unit, f"{meaning}; target, last frame with it")
    for group, (stage, when) in product(GROUPS, STAGES.items()):
        prefix = f"emergence.{group}.{stage}"
        yield Definition(f"{prefix}_delay_s", "s", f"median time from the first beam to the {when} (Kaplan-Meier)")
        yield Definition(f"{prefix}_range_m", "m", f"median range at the {when}; never counts as nearest")
        yield Definition(f"{prefix}_reached", "1", f"share of actors hit by a beam with: {when}")


def survival_measure(metric: str) -> tuple[str, str] | None:
    """Return stage and measure of a metric that a survival curve can show, or None."""
    for stage, measure in product(STAGES, SURVIVAL):
        if metric == f"emergence.{TARGET}.{stage}_{measure}":
            return stage, measure
    return None

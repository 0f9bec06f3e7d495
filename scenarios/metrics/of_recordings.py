"""Metrics that do not apply to a recording of a real sensor, with the reasons: they need more truth than poses."""

from collections.abc import Callable

from luxloop.scenarios.metrics.definition import Selection
from luxloop.scenarios.metrics.definitions import OF_LOOP, find_metric, standard_names
from luxloop.scenarios.result import Metric

NO_TRUTH = "the recording has no true poses"
NO_SIMULATION = "the scans were recorded, not simulated"
NO_CAUSES = "causes of single points are not known in a recording"
NO_OCCLUSION = "occlusion is not known in a recording"
NO_VIEWS = "visible sides are not known in a recording"
UNKNOWN = {
    "event": NO_SIMULATION,
    "removal": NO_CAUSES,
    "occlusion": NO_OCCLUSION,
    "track.id_switches_in_view": NO_OCCLUSION,
    "fit.bound_ratio": "the range noise of the sensor is not known",
}
"""Reasons by the kind or name of the metric."""


def why_not(has_truth: bool) -> Callable[[Selection], str]:
    """Return the function that says why a metric does not apply to a recording with or without true poses."""
    return _with_poses if has_truth else lambda _: NO_TRUTH


def _with_poses(selection: Selection) -> str:
    definition = selection.definition
    of_view = NO_VIEWS if "view" in selection.filters else ""
    return UNKNOWN.get(definition.name) or UNKNOWN.get(definition.kind) or of_view


def not_simulated() -> dict[str, Metric]:
    """Return the metrics of the run loop without values."""
    found = {name: find_metric(name).definition for name in standard_names()}
    return {name: Metric(None, one.unit, 0, NO_SIMULATION) for name, one in found.items() if one.kind in OF_LOOP}

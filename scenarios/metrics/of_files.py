"""Metrics that apply to boxes in files: those of tracks, as far as the files have the columns that they need."""

from collections.abc import Callable, Mapping

from luxloop.scenarios.metrics.definition import Selection
from luxloop.scenarios.metrics.definitions import DEFINITIONS

NO_RUN = "files of boxes have only truth and tracks"
NO_OCCLUSION = "occlusion is not known in files of boxes"
UNKNOWN = {
    "occlusion": NO_OCCLUSION,
    "track.id_switches_in_view": NO_OCCLUSION,
    "track.acceleration_abs_mean_mps2": "files of boxes have no accelerations",
}
"""Reasons by the kind or name of the metric, for all files."""
NAMES = tuple(
    name
    for name, one in DEFINITIONS.items()
    if name.startswith(("dataset.", "track.")) and name not in UNKNOWN and one.kind not in UNKNOWN
)
"""Metrics that a grading of files holds."""

NO_PARTS = ("regret", "extent", "coverage", "bound")
"""Beginnings of metrics of fits that need a rig, a trace or a covariance."""
OF_FITS = tuple(
    name for name in DEFINITIONS if name.startswith("fit.") and not name.removeprefix("fit.").startswith(NO_PARTS)
)
"""Metrics of rectangles in files. Those of nearest corners need positions about the ego."""
OF_CORNERS = ("fit.position", "fit.corner")
NO_EGO = "the positions are not about the ego, so the nearest corner is unknown"
NO_FIT = "no fit is on a graded true box"

COLUMNS = {
    "standing": "motion",
    "moving": "motion",
    "standing_since_seen": "motion",
    "stopped": "motion",
    "parked": "motion",
    "velocity_error_mps": "velocity",
    "speed_mps": "velocity",
    "speed_error_mps": "velocity",
    "speed_abs_error_mps": "velocity",
    "height_abs_error_m": "height",
    "wait_s": "time",
}
"""Needed contents of the files, by the column of a metric's values or rows."""
IN_METRES = dict.fromkeys(("gospa", "recall", "track"), "metres")
"""The same by the kinds of metrics."""
NAMED = {"track.amota": "score", "track.amotp_m": "score", "dataset.points_per_observation": "points"}
"""The same by the names of metrics."""


def why_not(missing: Mapping[str, str]) -> Callable[[Selection], str]:
    """Return the function that says why a metric does not apply to two files.

    Parameters
    ----------
    missing
        Reasons by what the files lack: `motion` (velocities of the truth), `velocity` (of both), `height`, `score`,
        `time`, `points`, `metres` (boxes on the ground), and the filters `class`, `range` and `view`.
    """

    def why(selection: Selection) -> str:
        definition = selection.definition
        found = UNKNOWN.get(definition.name) or UNKNOWN.get(definition.kind)
        if found or definition.name not in NAMES:
            return found or NO_RUN
        needed = (
            IN_METRES.get(definition.kind),
            NAMED.get(definition.name),
            COLUMNS.get(definition.rows),
            COLUMNS.get(definition.value),
        )
        return next((missing[one] for one in (*needed, *selection.filters) if one and one in missing), "")

    return why


def why_no_fit(about_ego: bool, fits: int) -> Callable[[Selection], str]:
    """Return the function that says why a metric does not apply to rectangles in a file, of which `fits` are graded."""

    def why(selection: Selection) -> str:
        name = selection.definition.name
        if name not in OF_FITS:
            return NO_RUN
        if not fits:
            return NO_FIT
        return NO_EGO if name.startswith(OF_CORNERS) and not about_ego else ""

    return why

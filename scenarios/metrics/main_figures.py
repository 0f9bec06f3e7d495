"""Main figures, which first screens, pages, comparisons and trends show, with their names for readers."""

SHORT_NAMES = {
    "track.hota": "HOTA",
    "track.idf1": "IDF1",
    "track.missed": "missed",
    "track.missed_share": "missed",
    "track.false": "false",
    "track.false_share": "false",
    "track.id_switches": "id switches",
    "track.id_switch_rate": "id switches",
    "track.position_abs_mean_m": "position error",
    "fit.heading_abs_mean_deg": "fit heading",
    "perf.realtime_factor": "x real time",
}
"""Headings of columns and captions of figures."""


def _named(*names: str) -> dict[str, str]:
    return {name: SHORT_NAMES[name] for name in names}


TRACKS = _named("track.hota", "track.idf1", "track.missed", "track.false", "track.id_switches")
OF_RUNS = TRACKS | _named("fit.heading_abs_mean_deg", "perf.realtime_factor")
"""Main figures of a run."""
OF_FILES = TRACKS | _named("track.position_abs_mean_m")
"""Main figures of tracks in a file."""
POOLED = _named("track.hota", "track.idf1", "track.missed_share", "track.false_share", "track.id_switch_rate") | {
    "fit.heading_abs_mean_deg": "fit heading [deg]"
}
"""Main figures of several runs together: shares and rates, since these may have different lengths."""
ON_FIRST_SCREEN = {
    "track.hota": "HOTA, tracking as a whole (1 is best)",
    "track.idf1": "IDF1, vehicles keep one id (1 is best)",
    "track.missed_share": "vehicles in view without a track",
    "fit.heading_abs_mean_deg": "heading error of fits, modulo 90 deg",
    "fit.position_abs_mean_m": "corner position error of fits",
    "track.moving_velocity_abs_mean_mps": "velocity error of moving vehicles",
    "track.heading_abs_mean_deg": "heading error of moving vehicles",
    "track.false_share": "false tracks over vehicles in view",
    "track.gospa_m": "GOSPA (0 is best)",
    "people.hota": "HOTA of people (1 is best)",
    "riders.hota": "HOTA of riders (1 is best)",
}
"""Main figures of the first screen with what they say, the most important first; a run without the first has others."""
